// The correction r of an objective: from a finer grid, and from photons where transport is asked
// for.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

namespace {

/// r outside is no grid error but noise of vanishing light.
constexpr double min_correction = 0.25;
constexpr double max_correction = 4.0;

}  // namespace

double Objective::refresh_correction(const Refinement& refinement, const CoefficientPair& fields) {
  ++solves_.refined;
  const GridShape& shape = refinement.setup.shape;
  const GridShape& own = problem_.setup.shape;
  const std::vector<double> kappa = split_voxels(exponential(fields.log_kappa), own, shape, 2);
  const std::vector<double> mu = split_voxels(exponential(fields.log_mu), own, shape, 2);
  const forward::SolverChoice finer =
      forward::make_grid_solver(refinement.setup, backend_.device, backend_.precision);
  finer.solver->set_medium(kappa, mu);
  const int batch =
      bounded_batch(shape, backend_.batch, backend_.refined_memory_mb, backend_.precision);
  std::vector<double> better = restrict_face(
      solve_exitance(*finer.solver, problem_.seen_face, refinement.irradiance, problem_.patterns,
                     batch, {backend_.refined_tolerance, backend_.solve.max_iterations},
                     &solves_.voxel_iterations),
      face_shape(shape, problem_.seen_face), problem_.seen_shape(), 2, problem_.patterns);
  if (!solve_forward(fields)) throw InputError("the diffusion solver failed at the current medium");
  Correction correction;
  if (refinement.photons) {
    PhotonRatio transport = transport_ratio(refinement, kappa, mu, better);
    for (std::size_t i = 0; i < better.size(); ++i) better[i] *= transport.ratio[i];
    correction.variance = std::move(transport.variance);
    correction.pixel_variance = std::move(transport.pixel_variance);
  }
  for (std::size_t i = 0; i < better.size(); ++i) {
    const double ratio = better[i] / exitance_[i];
    correction.ratio.push_back(
        std::isfinite(ratio) ? std::clamp(ratio, min_correction, max_correction) : 1.0);
  }
  set_correction(std::move(correction));
  return misfit();
}

PhotonRatio Objective::transport_ratio(const Refinement& refinement,
                                       const std::vector<double>& kappa,
                                       const std::vector<double>& mu,
                                       std::vector<double> diffusion) {
  misfit();  // with the r that is to be replaced
  const double excess =
      std::isfinite(data_term_.chi2_per_value) ? std::max(1.0, data_term_.chi2_per_value) : 1.0;
  PhotonProblem walk{refinement.setup,
                     kappa,
                     mu,
                     refinement.irradiance,
                     problem_.seen_face,
                     problem_.seen_shape(),
                     2,
                     problem_.patterns,
                     std::move(diffusion),
                     {}};
  for (const double weight : stated_weight_) {
    walk.variance.push_back(excess / weight);  // infinite where nothing is measured
  }
  PhotonRatio found = photon_ratio(walk, *refinement.photons);
  solves_.photons += static_cast<double>(found.photons) * problem_.patterns;
  return found;
}

/// Weights of the stated variances and `more`.
void Objective::add_to_variance(const std::vector<double>& more) {
  problem_.weight = stated_weight_;
  problem_.correction_variance = more;
  for (std::size_t i = 0; i < more.size(); ++i) {
    if (stated_weight_[i] > 0.0) problem_.weight[i] = 1.0 / (1.0 / stated_weight_[i] + more[i]);
  }
}

void Objective::set_correction(Correction correction) {
  const std::size_t data = problem_.data.size();
  check(correction.ratio.size() == data &&
            correction.variance.size() == correction.pixel_variance.size() &&
            (correction.variance.empty() || correction.variance.size() == data),
        "correction does not fit the data");
  correction_ = std::move(correction);
  add_to_variance(correction_.variance);
}

void Objective::count_pixel_noise() {
  add_to_variance(correction_.pixel_variance);
  if (!fluence_.empty()) misfit();
}

void Objective::restore(Correction correction, const SolveCount& solves) {
  set_correction(std::move(correction));
  solves_ = solves;
}

}  // namespace kappamu::inverse
