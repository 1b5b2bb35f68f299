// What fits cost and how good their volumes are.
//
// No fitted discretisation makes its own data: truths are solved on a grid twice as fine and get
// noise. Volumes are scored as exported: every voxel split in 2³, nothing corrected, noise-free
// truth, light the fit never saw (tests/cases/inverse_case.h).
#pragma once

#include "studies/subject.h"

namespace kappamu::studies {

/// What --json prints: sample, grid, channels, patterns, noise, optimiser, batched_solves, seconds,
/// validation_E, data_misfit_chi2, device and section of one fit: the default at 1 % noise, of the
/// median truth, from the first of scores, optimisers, samples and the others that was measured.
/// With section samples also `samples`, the rows of all that were asked for.
Json inverse_summary(const std::vector<Json>& records, const std::filesystem::path& folder);

}  // namespace kappamu::studies
