// The samples of [W] Table II at full size: from measurements to volumes, R, G and B.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/inverse_bench.h"
#include "core/progress.h"

namespace kappamu::bench {

/// wax1, wax2, marble, stone: made by data_synthetic at [W]'s sizes.
const std::vector<std::string>& paper_samples();

/// Hours [W] took on its GPU, Table II.
double paper_hours(const std::string& sample);

/// Data under the default light (capture::FitLight) are solved on a grid twice as fine and get 1 %
/// noise; each channel is fitted with the default options and judged by eight of the 8 × 8 patches.
/// One object per sample: sample, grid, channels, patterns, noise, seconds (of all channels,
/// deviations left out), deviation_seconds, batched_solves, holdout_E and data_misfit_chi2 by
/// channel, device.
nlohmann::ordered_json measure_sample(const std::string& sample, const InverseBenchOptions& options,
                                      Progress& progress);

/// Of measure_sample()'s objects, beside the paper's hours; Markdown.
std::string sample_table(const nlohmann::ordered_json& rows);

}  // namespace kappamu::bench
