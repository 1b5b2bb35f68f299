#include "inverse/problem/grid_levels.h"

#include <algorithm>
#include <utility>

#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::grid_levels;

}  // namespace

GridLevels::GridLevels(Problem finest, const ModelError& coarse_model_error, DataWeights weights,
                       int most) {
  const auto weighed = [&](Problem problem) {
    if (weights == DataWeights::equal) equalise_weights(problem);
    return problem;
  };
  problems_.push_back(weighed(std::move(finest)));
  while (count() < most) {
    const GridShape& s = problems_.back().setup.shape;
    if (std::min({s.nx, s.ny, s.nz}) < 2 * fewest_voxels) break;
    Problem coarser = coarsen(problems_.back(), coarse_model_error);
    if (coarser.used() < fewest_data) break;
    problems_.push_back(weighed(std::move(coarser)));
  }
  const auto& [relative, of_maximum] = coarse_model_error;
  const Problem& fine = problems_.front();
  if (count() > 2 && !fine.smooth_error.none() && relative + of_maximum > 0.0) {
    closer_ = weighed(coarsen(fine, {closer_share * relative, closer_share * of_maximum}));
  }
}

Refinement GridLevels::refinement(int level) const {
  const Problem& finer = (*this)[std::max(0, level - 1)];
  Refinement refinement = level == 0 ? refine(finer) : Refinement{finer.setup, finer.irradiance};
  refinement.photons = photons_;
  return refinement;
}

CoefficientPair GridLevels::to_finer(const CoefficientPair& fields, int level) const {
  const GridShape& coarse = (*this)[level].setup.shape;
  const GridShape& fine = (*this)[level - 1].setup.shape;
  return {prolong(fields.log_kappa, coarse, fine), prolong(fields.log_mu, coarse, fine)};
}

}  // namespace kappamu::inverse
