#include "inverse/problem/grid_path.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::grid_path;

/// The quantile `share`; 0 if there are none.
double at_most(std::vector<double>& deviations, double share) {
  if (deviations.empty()) return 0.0;
  const auto at = deviations.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(deviations.size()));
  std::nth_element(deviations.begin(), at, deviations.end());
  return *at;
}

}  // namespace

Backend as_loose_as_data(Backend backend, double usual_deviation, double least_deviation) {
  if (!backend.loose_solves) return backend;
  double& tolerance = backend.solve.tolerance;
  tolerance = std::max(tolerance, std::min(loosest, of_deviation * usual_deviation));
  double& refined = backend.refined_tolerance;
  refined = std::max(refined, std::min(loosest_correction, of_least_deviation * least_deviation));
  return backend;
}

double derivative_tolerance(const Backend& backend) {
  const double tolerance = backend.solve.tolerance;
  return backend.loose_solves ? std::max(tolerance, of_gradients) : tolerance;
}

std::vector<double> relative_deviations(const Problem& problem) {
  std::vector<double> deviations;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (problem.weight[i] == 0.0 || problem.data[i] == 0.0) continue;
    deviations.push_back(1.0 / (std::sqrt(problem.weight[i]) * std::abs(problem.data[i])));
  }
  return deviations;
}

GridPath::GridPath(GridLevels levels, const Backend& backend, const DataTermOptions& data_term,
                   GridCorrection correction)
    : levels_(std::move(levels)),
      backend_(backend),
      data_term_(data_term),
      correction_(correction) {}

void GridPath::open(int level, bool closer) {
  check(!closer || (level == 1 && levels_.closer()),
        "a grid that is not there to be fitted closer");
  level_ = level;
  closer_ = closer;
  Problem problem = closer ? *levels_.closer() : levels_[level];
  if (problem.precision) problem.precision->hold_mean(true);
  std::vector<double> deviations = relative_deviations(problem);
  const double usual = at_most(deviations, 0.5);
  const Backend backend = as_loose_as_data(backend_, usual, at_most(deviations, 0.05));
  objective_ = std::make_unique<Objective>(std::move(problem), backend, data_term_);
  objective_->set_derivative_tolerance(derivative_tolerance(backend));
}

double GridPath::renew_correction(const CoefficientPair& fields, double photon_noise) {
  if (correction_ == GridCorrection::none) {
    objective_->value(fields);
  } else {
    Refinement finer = refinement();
    if (finer.photons) finer.photons->noise = photon_noise;
    objective_->refresh_correction(finer, fields);
  }
  return objective_->chi2_per_value();
}

bool GridPath::go_closer() {
  if (level_ != 1 || closer_ || !levels_.closer()) return false;
  const Correction correction = objective_->correction();
  const SolveCount solves = objective_->solves();
  open(1, true);
  objective_->restore(correction, solves);
  return true;
}

CoefficientPair GridPath::refine(const CoefficientPair& fields) {
  CoefficientPair finer = levels_.to_finer(fields, level_);
  const SolveCount solves = objective_->solves();
  open(level_ - 1);
  objective_->restore(objective_->correction(), solves);
  return finer;
}

}  // namespace kappamu::inverse
