#include "inverse/data_checks/coarser_volume.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

Problem suitable_problem(const Problem& problem, const ModelError& model_error) {
  const GridShape& s = problem.setup.shape;
  if (std::min({s.nx, s.ny, s.nz}) >= defaults::consistency::enough_voxels) {
    Problem coarse = coarsen(problem, model_error);
    if (coarse.used() >= problem.used() / 8) return coarse;
  }
  return problem;
}

CoarserVolume on_suitable_grid(const FittedVolume& volume, const ModelError& model_error,
                               const Backend& backend) {
  Problem problem = suitable_problem(volume.problem, model_error);
  if (problem.precision) problem.precision->hold_mean(false);
  const GridShape& fine = volume.problem.setup.shape;
  const GridShape shape = problem.setup.shape;
  std::vector<double> prediction = volume.prediction;
  CoefficientPair fields = restrict_voxels(volume.fields, fine, shape);
  if (!(shape == fine)) {
    prediction = restrict_face(prediction, volume.problem.seen_shape(), problem.seen_shape(), 2,
                               problem.patterns);
  }
  auto objective = std::make_unique<Objective>(std::move(problem), backend, volume.data_term);
  if (!std::isfinite(objective->value(fields))) {
    throw InputError("the diffusion solver failed on voxels of twice the edge");
  }
  const std::vector<double> uncorrected = objective->prediction();
  for (std::size_t i = 0; i < prediction.size(); ++i) {
    prediction[i] = uncorrected[i] > 0.0 ? prediction[i] / uncorrected[i] : 1.0;
  }
  objective->set_correction({std::move(prediction)});
  objective->value(fields);
  return {std::move(fields), std::move(objective)};
}

}  // namespace kappamu::inverse
