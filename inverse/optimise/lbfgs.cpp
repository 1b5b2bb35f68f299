#include "inverse/optimise/lbfgs.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::optimiser;

/// Products of the gradient with steps and changes.
struct AlongGradient {
  std::vector<double> steps, changes;
};

/// Sets products[k] and returns those of the gradient with the pairs up to k.
AlongGradient multiply(LbfgsVectors& vectors, std::vector<LbfgsProducts>& products, std::size_t k) {
  const std::vector<double> sums = vectors.products(k);
  AlongGradient along;
  LbfgsProducts own;
  for (std::size_t j = 0; j <= k; ++j) {
    own.by_step.push_back(sums[4 * j]);
    along.steps.push_back(sums[4 * j + 1]);
    own.by_change.push_back(sums[4 * j + 2]);
    along.changes.push_back(sums[4 * j + 3]);
  }
  own.step_square = sums.back();
  products.resize(k + 1);
  products[k] = std::move(own);
  return along;
}

/// Pairs whose curvature is positive beyond rounding.
std::vector<std::size_t> usable_pairs(const std::vector<LbfgsProducts>& products) {
  std::vector<std::size_t> usable;
  for (std::size_t k = 0; k < products.size(); ++k) {
    const LbfgsProducts& p = products[k];
    if (p.curvature() > 1e-10 * std::sqrt(p.step_square * p.change_square())) usable.push_back(k);
  }
  return usable;
}

/// Length of the first trial: the whole direction, but nothing beyond longest_step.
double bounded_length(StepVectors& vectors, const OptimiserOptions& options) {
  return std::min(1.0, options.longest_step / vectors.amplitude());
}

/// Backtracks from `length` until the decrease is sufficient (Armijo). Returns f there; none after
/// max_backtracks.
std::optional<double> backtrack(StepVectors& vectors, double before, double slope, double length,
                                const OptimiserOptions& options) {
  for (int attempt = 0; attempt <= options.max_backtracks; ++attempt) {
    const double value = vectors.value_at(length);
    if (value <= before + sufficient_decrease * length * slope) return value;
    // The parabola through value, slope and the trial, kept within [0.1, 0.5]
    // of the length.
    const double curvature = value - before - slope * length;
    const double best = std::isfinite(curvature) && curvature > 0.0
                            ? -0.5 * slope * length * length / curvature
                            : 0.0;
    length = std::clamp(best, 0.1 * length, 0.5 * length);
  }
  return std::nullopt;
}

void forget_pairs(StepVectors& vectors, std::vector<LbfgsProducts>& products) {
  vectors.forget_pairs();
  products.clear();
}

void forget_oldest_pair(StepVectors& vectors, std::vector<LbfgsProducts>& products) {
  vectors.forget_oldest_pair();
  products.erase(products.begin());
  for (LbfgsProducts& p : products) {
    p.by_step.erase(p.by_step.begin());
    p.by_change.erase(p.by_change.begin());
  }
}

}  // namespace

double steepest_descent(LbfgsVectors& vectors) {
  return vectors.set_direction({});
}

double lbfgs_descent(LbfgsVectors& vectors, std::vector<LbfgsProducts>& products) {
  const std::size_t pairs = vectors.pairs();
  if (pairs == 0) return steepest_descent(vectors);
  AlongGradient along;
  for (std::size_t k = std::min(products.size(), pairs - 1); k < pairs; ++k) {
    along = multiply(vectors, products, k);
  }
  const std::vector<std::size_t> usable = usable_pairs(products);
  if (usable.empty()) return steepest_descent(vectors);
  const std::size_t count = usable.size();
  std::vector<double> alpha(count), beta(count);
  for (std::size_t k = count; k-- > 0;) {
    double product = along.steps[usable[k]];
    for (std::size_t j = k + 1; j < count; ++j) {
      product -= alpha[j] * products[usable[j]].by_step[usable[k]];
    }
    alpha[k] = product / products[usable[k]].curvature();
  }
  const LbfgsProducts& newest = products[usable.back()];
  const double scale = defaults::optimiser::softer * newest.curvature() / newest.change_square();
  for (std::size_t k = 0; k < count; ++k) {
    const LbfgsProducts& own = products[usable[k]];
    double product = along.changes[usable[k]];
    for (std::size_t j = 0; j < count; ++j) {
      const auto [older, newer] = std::minmax(usable[j], usable[k]);
      product -= alpha[j] * products[newer].by_change[older];
    }
    product *= scale;
    for (std::size_t j = 0; j < k; ++j) product += beta[j] * own.by_step[usable[j]];
    beta[k] = alpha[k] - product / own.curvature();
  }
  Combination of{-scale, std::vector<double>(pairs, 0.0), std::vector<double>(pairs, 0.0)};
  for (std::size_t k = 0; k < count; ++k) {
    of.steps[usable[k]] = -beta[k];
    of.changes[usable[k]] = scale * alpha[k];
  }
  return vectors.set_direction(of);
}

StepOutcome lbfgs_step(StepVectors& vectors, double& value, std::vector<LbfgsProducts>& products,
                       const OptimiserOptions& options) {
  double slope = lbfgs_descent(vectors, products);
  if (!(slope < 0.0)) {
    forget_pairs(vectors, products);
    slope = steepest_descent(vectors);
    if (!(slope < 0.0)) return StepOutcome::stalled;
  }
  const double length = vectors.pairs() == 0 ? options.first_step / vectors.amplitude()
                                             : bounded_length(vectors, options);
  if (const std::optional<double> found = backtrack(vectors, value, slope, length, options)) {
    if (vectors.pairs() >= static_cast<std::size_t>(options.memory)) {
      forget_oldest_pair(vectors, products);
    }
    value = *found;
    vectors.accept();
    return StepOutcome::progressed;
  }
  if (vectors.pairs() == 0) return StepOutcome::stalled;
  // A worn history can spoil the direction: once more along the gradient.
  forget_pairs(vectors, products);
  return lbfgs_step(vectors, value, products, options);
}

}  // namespace kappamu::inverse
