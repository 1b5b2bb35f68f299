// Are the standard deviations of a fit those of fits? On a block small enough for dense matrices:
// the spread of fits to repeated noise against the spread predicted, after mrcal's test of its
// projection uncertainty (dkogan/mrcal, test-projection-uncertainty.py).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/grid.h"
#include "inverse/uncertainty/uncertainty.h"
#include "studies/inverse/dense_fit.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::studies {

struct ProofOptions {
  GridShape grid{12, 12, 6, 0.5};
  int side = 4;          ///< side² patterns
  double noise = 0.01;   ///< relative to each datum (Block::noise)
  double weight = 30.0;  ///< α
  std::uint64_t seed = 1;
  std::string device = "auto";
};

/// A fitted block and its posterior by dense matrices.
class Proof {
 public:
  /// Data of a smooth medium with an absorbing box from a grid twice as fine; fields and grid
  /// correction are those of the minimum for data without noise, and stay.
  explicit Proof(const ProofOptions& options);

  Eigen::Index unknowns() const { return fit_.unknowns(); }
  const Variances& posterior() const { return posterior_; }    ///< diag H⁻¹
  const Variances& prior() const { return prior_; }            ///< diag (α R″)⁻¹
  const Variances& noise_part() const { return noise_part_; }  ///< diag H⁻¹ JᵀWJ H⁻¹
  inverse::Objective& objective() { return fit_.objective(); }

  /// Variances over `count` fits of the full, not linearised, objective to data with fresh noise.
  Variances sampled_noise_part(int count);
  /// Largest ‖∇J‖ of those fits where they ended, against where they began.
  double unconverged() const { return fit_.unconverged(); }

  /// Mean squares of estimate − truth over `count` truths drawn from the prior and fitted to noisy
  /// data of the linearised problem.
  Variances sampled_posterior(int count);

  /// That of inverse::estimate_uncertainty, of as many adjoint solves.
  Variances estimated_posterior(int probes);

 private:
  ProofOptions options_;
  DenseFit fit_;
  Variances posterior_, prior_, noise_part_;
  test_cases::Noise noise_;
};

/// Quantiles of √(found/expected) over the unknowns that `use` allows.
struct DeviationRatio {
  double low = 0.0;  ///< 5 %
  double median = 0.0;
  double high = 0.0;  ///< 95 %
  std::size_t count = 0;
};
DeviationRatio deviation_ratio(const Variances& found, const Variances& expected,
                               const std::vector<bool>& use);

}  // namespace kappamu::studies
