// `kappamu-studies figures`: the papers' figures made again.
#pragma once

#include "studies/subject.h"

namespace kappamu::studies {

/// Figures that are pictures of scenes (figure_file.h): figures-<name>.png, tiles in the paper's
/// arrangement. Rows: seconds of each cell, and how far its exitance is from another column's.
void figure_pictures(const Request& request, Progress& progress, const Save& save);
/// [W] 10 to 12: the four samples fitted from n × n patches; volume-<sample> holds the volume found
/// from 16 images, which figures with wrapped samples read.
void figure_samples(const Request& request, Progress& progress, const Save& save);
/// [W] 13 and 14: a block by the paper's scheme at three weights and by the default, slices by
/// depth.
void figure_weights(const Request& request, Progress& progress, const Save& save);
/// [T] 4.1: stair steps against cut cells, a sphere whose exitance is known.
void figure_stairs(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies
