// The samples of [W] Table II at full size: from measurements to volumes, R, G and B.
#pragma once

#include <string>
#include <vector>

#include "studies/subject.h"

namespace kappamu::studies {

/// wax1, wax2, marble, stone: made by data_synthetic at [W]'s sizes.
const std::vector<std::string>& paper_samples();

/// Data under the default light (capture::FitLight) are solved on a grid twice as fine and get 1 %
/// noise; each channel is fitted with the default options and compared under eight of the 8 × 8
/// patches. One object per sample: sample, grid, channels, patterns, noise, seconds (of all
/// channels, deviations left out), deviation_seconds, batched_solves, device; by channel
/// validation_E, data_misfit_chi2 and, of κ and μ, coverage (synthetic::Coverage): share of all
/// voxels and of the worst layer.
Json measure_sample(const std::string& sample, const Request& request, Progress& progress);

}  // namespace kappamu::studies
