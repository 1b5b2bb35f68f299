// Real photographs under sinusoidal light: nine phantoms, each measured with each other one as
// reference, and tissue, against the coefficients published with them.
#pragma once

#include "core/progress.h"
#include "studies/subject.h"

namespace kappamu::studies::sfdi {

/// --data: the folder with peer_rd.csv. Reflectance beside two other groups' Monte Carlo, and
/// diffusion beside it.
void measure_peer(const Request& request, Progress& progress, const Save& save);

/// --data: the folder with phantoms.csv, phantoms/ and pig/. Leave one out over the phantoms.
void measure_phantoms(const Request& request, Progress& progress, const Save& save);

/// The same folder: each tissue with each phantom as reference, pixel by pixel.
void measure_tissue(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies::sfdi
