// The data's Hessian as the metric of the fit needs it: per lateral frequency, from a few random
// adjoint solves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "inverse/optimise/basis.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// g = JᵀW^½ s of random signs s on the data: E[g gᵀ] = JᵀWJ. At the fields of the objective's last
/// value(); one adjoint solve each.
std::vector<CoefficientPair> random_rows(Objective& objective, int probes, std::uint64_t seed);

/// √diag(JᵀWJ) for log κ and log μ of each voxel [standard deviations of the data per unit of log],
/// from random_rows() (Bekas, Kokiopoulou & Saad 2007); relative error of each voxel about
/// √(1/(2 rows)).
CoefficientPair estimate_sensitivity(std::span<const CoefficientPair> rows);

/// The lateral waves of g of one frequency band are as many samples of that band's matrix; bands
/// with fewer samples than rows borrow from their neighbours. `ridge` times a block's mean diagonal
/// is added to it, because few samples do not determine its smallest eigenvalues.
LateralBlocks lateral_blocks(std::span<const CoefficientPair> rows, const MediumSpace& space,
                             double ridge = 1e-3);

/// The two halves of lateral_blocks(): Σ w wᵀ over the waves w of the rows in each bin; and the
/// blocks of such sums over so many `samples` each.
LateralBlocks lateral_sums(std::span<const CoefficientPair> rows, const LateralWaves& waves);
LateralBlocks pooled_blocks(const LateralBlocks& sums, const std::vector<int>& samples,
                            double ridge = 1e-3);
/// How many bins on both sides of `bin` pooled_blocks() makes its block of.
int pooled_reach(const std::vector<int>& samples, int bin, int rows);

}  // namespace kappamu::inverse
