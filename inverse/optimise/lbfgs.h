// A step of L-BFGS (Nocedal & Wright, algorithm 7.4), on vectors wherever they live. Its direction
// is made from inner products of the pairs, as two passes over memory: one for the products with
// the newest change and the gradient, one for the direction. The two loops of the algorithm run on
// these products (Chen et al., "Large-scale L-BFGS using MapReduce", 2014).
#pragma once

#include <cstddef>
#include <vector>

#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse {

/// gradient · g + Σ steps[k] s_k + changes[k] y_k, over all pairs or over none.
struct Combination {
  double gradient = -1.0;
  std::vector<double> steps, changes;
};

/// The gradient g at z, and pairs of a step s_k and the gradient's change y_k, oldest first.
class LbfgsVectors {
 public:
  virtual ~LbfgsVectors() = default;
  virtual std::size_t pairs() const = 0;
  /// s_j·y_k, s_j·g, y_j·y_k and y_j·g for every j ≤ k in turn, then s_k·s_k.
  virtual std::vector<double> products(std::size_t k) = 0;
  /// Sets the direction d. Returns d·g.
  virtual double set_direction(const Combination& of) = 0;
};

/// With the line that is searched.
class StepVectors : public LbfgsVectors {
 public:
  /// Function::amplitude() of the direction.
  virtual double amplitude() = 0;
  /// f(z + length · d).
  virtual double value_at(double length) = 0;
  /// The point of the last value_at() becomes z, and the way there the newest pair.
  virtual void accept() = 0;
  virtual void forget_pairs() = 0;
  virtual void forget_oldest_pair() = 0;
};

/// Sets the direction −g, or −H g, which completes `products`. Returns its slope, d·g.
double steepest_descent(LbfgsVectors& vectors);
double lbfgs_descent(LbfgsVectors& vectors, std::vector<LbfgsProducts>& products);

/// One step from z with f(z) = `value`. `products` are those of the pairs.
StepOutcome lbfgs_step(StepVectors& vectors, double& value, std::vector<LbfgsProducts>& products,
                       const OptimiserOptions& options);

}  // namespace kappamu::inverse
