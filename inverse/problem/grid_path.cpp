#include "inverse/problem/grid_path.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/numbers/median.h"

namespace kappamu::inverse {

namespace {

/// Solves err by this share of a datum's usual deviation, but by no more than the second: fits end
/// at the same E as with exact ones (docs/theory.md, section 4).
constexpr double solver_share_of_noise = 0.1;
constexpr double loosest_solve = 1e-3;

/// `backend` with solves as loose as the data allow; refined ones, few, stay exact: r corrects all
/// the data.
Backend suited(Backend backend, const Problem& problem) {
  std::vector<double> deviations;  // relative
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (problem.weight[i] == 0.0 || problem.data[i] == 0.0) continue;
    deviations.push_back(1.0 / (std::sqrt(problem.weight[i]) * std::abs(problem.data[i])));
  }
  if (deviations.empty()) return backend;
  const double allowed =
      std::min(loosest_solve, solver_share_of_noise * upper_median(std::move(deviations)));
  backend.solve.tolerance = std::max(backend.solve.tolerance, allowed);
  return backend;
}

}  // namespace

GridPath::GridPath(GridLevels levels, const Backend& backend, const DataTermOptions& data_term,
                   GridCorrection correction)
    : levels_(std::move(levels)),
      backend_(backend),
      data_term_(data_term),
      correction_(correction) {}

void GridPath::open(int level) {
  level_ = level;
  const Problem& problem = levels_[level];
  objective_ = std::make_unique<Objective>(problem, suited(backend_, problem), data_term_);
}

double GridPath::thickness_mm() const {
  return shape().extent(axis_of(problem().setup.lit_face)) * shape().voxel_mm;
}

double GridPath::renew_correction(const CoefficientPair& fields) {
  if (correction_ == GridCorrection::none) {
    objective_->value(fields);
  } else {
    objective_->refresh_correction(refinement(), fields);
  }
  return objective_->chi2_per_value();
}

CoefficientPair GridPath::refine(const CoefficientPair& fields) {
  CoefficientPair finer = levels_.to_finer(fields, level_);
  const SolveCount solves = objective_->solves();
  open(level_ - 1);
  objective_->restore(objective_->correction(), solves);
  return finer;
}

}  // namespace kappamu::inverse
