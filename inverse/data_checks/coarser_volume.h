// A fit's volume on voxels of twice the edge, where a question about it costs an eighth.
#pragma once

#include <memory>
#include <vector>

#include "inverse/problem/objective.h"
#include "inverse/uncertainty/prior.h"

namespace kappamu::inverse {

/// The end of a volume's fit.
struct FittedVolume {
  const Problem& problem;  ///< the finest grid's
  const CoefficientPair& fields;
  const std::vector<double>& prediction;  ///< [M][v][u], as `problem.data`
  const Prior& prior;                     ///< of the fit's α
  const DataTermOptions& data_term;
};

/// `problem` on voxels of twice the edge where there are enough, else as it is; `model_error` is
/// the one in its weights.
Problem suitable_problem(const Problem& problem, const ModelError& model_error);

/// The volume on the grid of suitable_problem(), and an objective at it, whose r makes its
/// prediction there what the fit's was.
struct CoarserVolume {
  CoefficientPair fields;
  std::unique_ptr<Objective> objective;
};
CoarserVolume on_suitable_grid(const FittedVolume& volume, const ModelError& model_error,
                               const Backend& backend);

}  // namespace kappamu::inverse
