#include "inverse/optimise/optimiser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "inverse/optimise/host_vectors.h"

namespace kappamu::inverse {

namespace {

/// Σ term(i) over [begin, end), in sums of their own for vector registers.
template <class Term>
double sum_of(std::size_t begin, std::size_t end, const Term& term) {
  constexpr std::size_t lanes = 8;
  std::array<double, lanes> lane{};
  std::size_t i = begin;
  for (; i + lanes <= end; i += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) lane[k] += term(i + k);
  }
  for (; i < end; ++i) lane[0] += term(i);
  return std::accumulate(lane.begin(), lane.end(), 0.0);
}

template <class A, class B>
double dot(const Function& function, const std::vector<A>& a, const std::vector<B>& b) {
  std::vector<double> sums(pieces(a.size()));
  for_pieces(a.size(), [&](std::size_t piece, std::size_t begin, std::size_t end) {
    sums[piece] = sum_of(begin, end, [&](std::size_t i) {
      return static_cast<double>(a[i]) * static_cast<double>(b[i]);
    });
  });
  double sum = std::accumulate(sums.begin(), sums.end(), 0.0);
  function.total({&sum, 1});
  return sum;
}

template <class T>
void add_scaled(Vector& to, double factor, const std::vector<T>& term) {
  for_pieces(to.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) to[i] += factor * static_cast<double>(term[i]);
  });
}

Vector negative(Vector v) {
  for_pieces(v.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) v[i] = -v[i];
  });
  return v;
}

/// A point on the search line, not yet accepted.
struct Trial {
  Vector z;
  double value = 0.0;
};

Trial evaluate(Function& function, const OptimiserState& state, const Vector& direction,
               double length) {
  Trial trial{state.z, 0.0};
  add_scaled(trial.z, length, direction);
  trial.value = function.value(trial.z);
  return trial;
}

/// The trial must be the last point evaluated.
void accept(Function& function, OptimiserState& state, Trial trial) {
  state.z = std::move(trial.z);
  state.value = trial.value;
  state.gradient = function.gradient();
}

StepOutcome wang2008_step(Function& function, OptimiserState& state,
                          const OptimiserOptions& options) {
  Vector p = negative(state.gradient);
  Vector direction = p;
  if (!state.direction.empty()) {
    const double denominator = dot(function, state.previous_gradient, state.previous_gradient);
    const double beta = std::max(
        0.0, (dot(function, p, p) - dot(function, p, state.previous_gradient)) / denominator);
    add_scaled(direction, beta, state.direction);
    if (!(dot(function, direction, p) > 0.0)) direction = p;
  }
  // Bracket a minimum from the last step's length, then shrink it by the golden
  // section.
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  const double unit = state.previous_step > 0.0
                          ? state.previous_step
                          : options.first_step / function.amplitude(state.z, direction);
  Trial best = evaluate(function, state, direction, unit);
  double left = 0.0;
  double middle = unit;
  double right = unit;
  for (int k = 0; best.value >= state.value; ++k) {
    if (k == options.max_backtracks) return StepOutcome::stalled;
    right = middle;
    middle *= 1.0 - golden;
    best = evaluate(function, state, direction, middle);
  }
  if (right == middle) {
    for (int k = 0; k < options.max_backtracks; ++k) {
      right = middle + (middle - left) / golden;
      Trial further = evaluate(function, state, direction, right);
      if (further.value >= best.value) break;
      left = middle;
      middle = right;
      best = std::move(further);
    }
  }
  while (right - left > options.golden_tolerance * middle) {
    const bool into_right = right - middle > middle - left;
    const double probe = into_right ? middle + (1.0 - golden) * (right - middle)
                                    : middle - (1.0 - golden) * (middle - left);
    Trial trial = evaluate(function, state, direction, probe);
    if (trial.value < best.value) {
      (into_right ? left : right) = middle;
      middle = probe;
      best = std::move(trial);
    } else {
      (into_right ? right : left) = probe;
    }
  }
  // gradient() belongs to the last point evaluated.
  best = evaluate(function, state, direction, middle);
  state.previous_step = middle;
  state.direction = std::move(direction);
  state.previous_gradient = std::move(p);
  accept(function, state, std::move(best));
  return StepOutcome::progressed;
}

}  // namespace

void start(Function& function, OptimiserState& state) {
  OptimiserState fresh;
  fresh.z = std::move(state.z);
  fresh.value = function.value(fresh.z);
  fresh.gradient = function.gradient();
  state = std::move(fresh);
}

void restart(Function& function, OptimiserState& state, const PairTranslation& translate) {
  OptimiserState before = std::move(state);
  state = {};
  state.z = std::move(before.z);
  start(function, state);
  for (std::size_t k = 0; k < before.steps.size(); ++k) {
    // One pair at a time is held twice.
    const std::vector<float> old_step = std::exchange(before.steps[k], {});
    const std::vector<float> old_change = std::exchange(before.changes[k], {});
    Vector step(old_step.begin(), old_step.end());
    Vector change(old_change.begin(), old_change.end());
    translate(step, change);
    if (!(dot(function, step, change) > 0.0)) continue;
    state.steps.emplace_back(step.begin(), step.end());
    state.changes.emplace_back(change.begin(), change.end());
  }
}

StepOutcome step(Function& function, OptimiserState& state, const OptimiserOptions& options) {
  if (options.method == Method::wang2008) return wang2008_step(function, state, options);
  HostVectors vectors(function, state);
  return lbfgs_step(vectors, state.value, state.products, options);
}

}  // namespace kappamu::inverse
