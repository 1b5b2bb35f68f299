// The measured edges of the grid solver and of the fit: every table of docs/limits.md, by name. No
// times: they belong to docs/benchmarks.md.
#pragma once

#include <string>
#include <vector>

#include "bench/limit_table.h"
#include "core/progress.h"

namespace kappamu::bench {

struct LimitsOptions {
  std::string device = "auto";
  bool large = true;  ///< grids of 256³ too: 3 GB and many minutes
};

struct LimitName {
  std::string id;
  std::string description;  ///< one line
};
const std::vector<LimitName>& limit_names();

/// Throws InputError listing the names when there is no such table.
LimitTable measure_limit(const std::string& id, const LimitsOptions& options, Progress& progress);

// One per table; limits_*.cpp.
LimitTable limit_contrast(const LimitsOptions& options, Progress& progress);
LimitTable limit_size(const LimitsOptions& options, Progress& progress);
LimitTable limit_floor(const LimitsOptions& options, Progress& progress);
LimitTable limit_absorption(const LimitsOptions& options, Progress& progress);
LimitTable limit_mirror(const LimitsOptions& options, Progress& progress);
LimitTable limit_shape(const LimitsOptions& options, Progress& progress);
LimitTable limit_boundary(const LimitsOptions& options, Progress& progress);
LimitTable limit_coarse(const LimitsOptions& options, Progress& progress);
LimitTable limit_stencil(const LimitsOptions& options, Progress& progress);
LimitTable limit_relaxation(const LimitsOptions& options, Progress& progress);
LimitTable limit_inverse(const LimitsOptions& options, Progress& progress);
LimitTable limit_consistency(const LimitsOptions& options, Progress& progress);

}  // namespace kappamu::bench
