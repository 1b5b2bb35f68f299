// Standard deviations of fits against the truth, over blocks no choice has seen. A section of
// `kappamu-studies inverse`.
#pragma once

#include <vector>

#include "core/grid.h"
#include "inverse/uncertainty/uncertainty.h"
#include "studies/subject.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::studies {

/// What a fit that states `layers` can find of a truth on finer cells.
Medium resolved_truth(const Medium& fine, const test_cases::Block& block,
                      const std::vector<inverse::LayerUncertainty>& layers);

/// Truths of four families (tests/cases/population.h) under bars at three noises, fitted as volumes
/// by the default options. Rows: family, seed, noise and, of `kappa` and `mu`, by layer from the
/// lit face: `within`, the share of voxels within two stated deviations of the truth as resolved,
/// `error`, the mean error of the logarithm, and `stated`, the deviations' root mean square. The
/// voxels of a layer err together: its share in one block is little more than one draw.
void measure_coverage(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies
