// One fit at the edge of what measurements can tell, and what came of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "inverse/fit/fit.h"
#include "tests/cases/limit_inverse_case.h"

namespace kappamu::test_cases {

struct InverseLimit {
  std::string name{};
  Block block{};
  Figure3 figure{};
  int side = 4;  ///< patterns: side × side patches
  Mistake mistake{};
  double eta = 1.3;          ///< of the block
  bool half_masked = false;  ///< nothing is measured beyond the middle of the seen face, along u
  bool transport = false;    ///< data by Monte Carlo instead of diffusion
  double anisotropy = 0.0;   ///< g of that transport
  bool dark = false;         ///< no light reached the camera
  inverse::FitOptions options{};
};

struct InverseLimitOutcome {
  std::optional<inverse::ChannelFit> fit;  ///< none where there is nothing to fit
  std::vector<std::string> warnings;       ///< its own, or the sentence it ended with
  std::vector<std::string> notes;
  double error = 0.0;        ///< E under 6 × 6 patches against noise-free, right data
  double kappa_error = 0.0;  ///< median over voxels of |found/true − 1|
  double mu_error = 0.0;
};

/// Those of docs/limits.md; tests/stability holds bounds on them.
std::vector<InverseLimit> inverse_limits();

/// The one of that name; InternalError when there is none.
InverseLimit inverse_limit(const std::string& name);

InverseLimitOutcome run_inverse_limit(const InverseLimit& limit, const std::string& device);

}  // namespace kappamu::test_cases
