// The long waves of log κ and log μ, which are stronger than H1 expects: its weight is that of the
// many short waves that the data determine. What a fit misses of them is of long waves too, so that
// a coarse grid shows it, by as many products with the Hessian as it takes (docs/theory.md, 5).
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid.h"
#include "inverse/optimise/basis.h"
#include "inverse/problem/objective.h"
#include "inverse/uncertainty/prior.h"

namespace kappamu::inverse {

/// The weight of H1 that expects what was found of log κ in each band of waves, as
/// empirical_prior() has it for all of them; none above the fit's. Bands are of the eigenvalue of
/// the voxels' 3-point Laplacian, half a decade each. `regulariser` is the fit's, `log_kappa` less
/// its anchor, `blocks` by prior_blocks().
std::vector<double> wave_weights(const Prior& regulariser, const Vector& log_kappa,
                                 const LateralBlocks& blocks, const GridShape& shape,
                                 int depth_axis);

/// By layer along the depth axis, from its lower end; empty: none.
struct LayerVariance {
  Vector log_kappa;
  Vector log_mu;
  Vector between;
};

struct LongWaveErrors {
  LayerVariance error;       ///< of a fit
  LayerVariance beforehand;  ///< of the waves themselves
  int solves = 0;            ///< batched ones on the coarse grid
};

struct LongWaveOptions {
  int draws = 2;
  int steps = 500;  ///< of conjugate gradients at most, each two batched solves
  int probes = 64;  ///< adjoint solves for their preconditioner
};

/// What a fit whose regulariser has `prior.weight` misses of waves drawn from the excess of
/// `prior.wave_weights` over it. `coarse`: of a grid of voxels 2^n as large as those of `shape`, at
/// the fields of its last value().
LongWaveErrors long_wave_errors(Objective& coarse, const Prior& prior, const GridShape& shape,
                                int depth_axis, const LongWaveOptions& options, std::uint64_t seed);

}  // namespace kappamu::inverse
