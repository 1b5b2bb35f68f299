#include "inverse/data_checks/physics_choice.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/numbers/median.h"
#include "core/shown_text.h"
#include "forward/analytic/validity.h"

namespace kappamu::inverse {

namespace {

/// Median relative deviation of the data.
double data_error(const Problem& problem) {
  std::vector<double> deviations;
  for (std::size_t i = 0; i < problem.data.size(); ++i) {
    if (problem.weight[i] == 0.0 || problem.data[i] == 0.0) continue;
    deviations.push_back(1.0 / (std::sqrt(problem.weight[i]) * std::abs(problem.data[i])));
  }
  return deviations.empty() ? 1.0 : upper_median(std::move(deviations));
}

/// Of what the seen face shows; where too little light arrives there to know it, of the light
/// reflected.
double diffusion_error(const Problem& problem, const forward::ValidityEstimate& estimate) {
  const double reflected = std::abs(estimate.reflected.value_or(0.0));
  if (problem.seen_face == problem.setup.lit_face || !estimate.transmitted) return reflected;
  return std::max(std::abs(*estimate.transmitted), estimate.far_map.value_or(0.0));
}

}  // namespace

PhysicsChoice choose_physics(const Problem& problem, double kappa, double mu) {
  const GridShape& shape = problem.setup.shape;
  const double extinction = 1.0 / (3.0 * kappa);
  const double paths = extinction * shape.extent(axis_of(problem.setup.lit_face)) * shape.voxel_mm;
  const double albedo = std::max(0.0, 1.0 - mu / extinction);
  const double model = diffusion_error(problem, forward::diffusion_validity(albedo, paths));
  const double data = data_error(problem);
  const bool transport = model > data;
  std::string reason = formatted(
      "Diffusion errs by about %.2g %% in a slab like this block (albedo %.3g, %.2g "
      "transport mean free paths thick), the data by %.2g %%: the fit is by %s.",
      100.0 * model, albedo, paths, 100.0 * data, transport ? "transport" : "diffusion");
  return {transport ? Physics::transport : Physics::diffusion, std::move(reason)};
}

}  // namespace kappamu::inverse
