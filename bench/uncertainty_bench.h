// The proof of a fit's standard deviations as a record and charts, and what each way to estimate
// them costs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/uncertainty_proof.h"
#include "core/progress.h"

namespace kappamu::bench {

struct UncertaintyBenchOptions {
  ProofOptions proof;
  int fits = 60;      ///< to fresh noise
  int truths = 1000;  ///< drawn from the prior
  std::filesystem::path folder;
};

/// Predicted against found by one way to know a deviation.
struct UncertaintyRow {
  std::string method;
  int solves = 0;  ///< batched ones; 0 where the question does not arise
  DeviationRatio ratio;
};

struct UncertaintyBench {
  std::vector<UncertaintyRow> proof;       ///< found by sampling, against the exact prediction
  std::vector<UncertaintyRow> estimators;  ///< estimated, against the exact posterior
};

/// Writes uncertainty.json, bench-uncertainty.png, bench-uncertainty-cost.png (each with its
/// script) and table-uncertainty.md into the folder.
UncertaintyBench measure_uncertainty(const UncertaintyBenchOptions& options, Progress& progress);

}  // namespace kappamu::bench
