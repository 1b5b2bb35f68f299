// Dipole models measured (docs/dipole.md): cost and error of the hierarchy in [M]'s three modes,
// samples of local diffusion.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

/// Rows per number of triangles.
void dipole_hierarchy(const Request& request, Progress& progress, const Save& save);
/// Rows per scene, kind of samples and their number.
void dipole_importance(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
