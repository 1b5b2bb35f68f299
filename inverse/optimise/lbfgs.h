// The direction of L-BFGS (Nocedal & Wright, algorithm 7.4) from inner products of the pairs, as
// two passes over memory: one for the products with the newest change and the gradient, one for the
// direction. The two loops of the algorithm run on these products (Chen et al., "Large-scale L-BFGS
// using MapReduce", 2014).
#pragma once

#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse {

struct Descent {
  Vector direction;
  double slope = 0.0;  ///< direction · gradient
};

Descent steepest_descent(const Function& function, const OptimiserState& state);
/// −H g; completes state.products.
Descent lbfgs_descent(const Function& function, OptimiserState& state);

}  // namespace kappamu::inverse
