// Exitance of a grid of half the voxels' edge, as means over a problem's own pixels, without
// leaving the memory of the finer grid's device.
#pragma once

#include <vector>

#include "forward/device_medium.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// A medium of `fields` on `own`, every voxel split, log κ and log μ lowered by so much.
struct SplitMedium {
  const CoefficientPair& fields;
  const GridShape& own;
  std::array<double, 2> lower{};
};

/// Sets the medium of `finer`, which must have a device.
void set_split(forward::DiffusionOperator& finer, const SplitMedium& medium);

/// Under `light` of so many `patterns`, solved as solve_exitance() does: [pattern][face][v][u] of
/// faces of `own` pixels.
std::vector<double> restricted_exitance(forward::DiffusionOperator& finer,
                                        const std::vector<double>& light, int patterns,
                                        const FaceShape& fine, const FaceShape& own,
                                        const BatchedSolve& solve);

}  // namespace kappamu::inverse
