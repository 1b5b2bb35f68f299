// Standard deviations of fits against the truth, over blocks no choice has seen. A section of
// `kappamu bench inverse`.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

/// Truths of four families (bench/cases/population.h) under bars at three noises, fitted as volumes
/// by the default options. Rows: family, seed, noise and, of `kappa` and `mu`, by layer from the
/// lit face: `within`, the share of voxels within two stated deviations, `error`, the mean error of
/// the logarithm, and `stated`, the deviations' root mean square. The voxels of a layer err
/// together: its share in one block is little more than one draw.
void measure_coverage(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
