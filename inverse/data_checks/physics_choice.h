// Whether diffusion is good enough for data of this precision: its error in a slab like the block
// (forward/analytic/validity.h, docs/validity.md) against the data's own.
#pragma once

#include <string>

#include "inverse/problem/photon_ratio.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

struct PhysicsChoice {
  Physics physics = Physics::diffusion;
  std::string reason;  ///< one sentence
};

/// Of `problem`, on the finest grid, for a block of `kappa` [mm] and `mu` [1/mm]: transport where
/// the larger of diffusion's errors on the seen face (its total; on the far face the map under a
/// patch too) exceeds the median relative deviation of the data, model error included.
PhysicsChoice choose_physics(const Problem& problem, double kappa, double mu);

}  // namespace kappamu::inverse
