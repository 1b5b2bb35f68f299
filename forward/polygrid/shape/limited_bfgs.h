// Limited-memory BFGS with Armijo backtracking (Nocedal and Wright 2006, algorithm 7.4), for
// functions that are infinite where they are not allowed.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <deque>

namespace kappamu::forward {

/// `function(x, gradient)` returns the value and sets the gradient; it is finite at `x`.
/// `first_step`: the largest change of an unknown in the first iteration. Returns the last value.
template <class Function>
double minimise(const Function& function, Eigen::VectorXd& x, int iterations, double first_step) {
  constexpr std::size_t memory = 6;
  constexpr double decrease = 1e-4;
  struct Pair {
    Eigen::VectorXd step, change;
    double inverse_product;
  };
  std::deque<Pair> pairs;
  Eigen::VectorXd gradient(x.size()), next_gradient(x.size()), direction, next;
  double value = function(x, gradient);
  std::array<double, memory> alpha{};
  for (int iteration = 0; iteration < iterations; ++iteration) {
    direction = -gradient;
    for (std::size_t k = pairs.size(); k-- > 0;) {
      alpha[k] = pairs[k].inverse_product * pairs[k].step.dot(direction);
      direction -= alpha[k] * pairs[k].change;
    }
    if (pairs.empty()) {
      const double largest = gradient.lpNorm<Eigen::Infinity>();
      if (!(largest > 0.0)) return value;
      direction *= first_step / largest;
    } else {
      direction /= pairs.back().inverse_product * pairs.back().change.squaredNorm();
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const double beta = pairs[k].inverse_product * pairs[k].change.dot(direction);
      direction += (alpha[k] - beta) * pairs[k].step;
    }
    const double slope = direction.dot(gradient);
    if (!(slope < 0.0)) return value;
    double length = 1.0, next_value = 0.0;
    for (int halvings = 0;; ++halvings) {
      next = x + length * direction;
      next_value = function(next, next_gradient);
      if (next_value <= value + decrease * length * slope) break;
      if (halvings == 30) return value;
      length /= 2.0;
    }
    Pair pair{next - x, next_gradient - gradient, 0.0};
    const double product = pair.step.dot(pair.change);
    x.swap(next);
    gradient.swap(next_gradient);
    value = next_value;
    if (product > 1e-12 * pair.step.norm() * pair.change.norm()) {
      pair.inverse_product = 1.0 / product;
      if (pairs.size() == memory) pairs.pop_front();
      pairs.push_back(std::move(pair));
    }
  }
  return value;
}

}  // namespace kappamu::forward
