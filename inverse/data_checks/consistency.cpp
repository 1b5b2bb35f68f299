#include "inverse/data_checks/consistency.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "core/error.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::consistency;

constexpr ErrorSteps volume_steps{most_steps, early_steps, least_early_gain};
/// Standard errors that `patterns` patterns have estimated: Student's t exceeds so many of them as
/// rarely as a normal number exceeds `most_deviations` (to first order in 1/degrees of freedom).
double student(int patterns) {
  constexpr double z = most_deviations;
  return z + (z * z * z + z) / (4.0 * (patterns - 1));
}

double limit(double standard_error, int patterns, double spread) {
  return std::hypot(student(patterns) * standard_error, most_deviations * spread);
}

struct Grid {
  Problem problem;
  Refinement finer;
};

Grid suitable_grid(const Problem& problem, const ModelError& model_error) {
  Problem suitable = suitable_problem(problem, model_error);
  const bool coarser = !(suitable.setup.shape == problem.setup.shape);
  Refinement finer = coarser ? Refinement{problem.setup, problem.irradiance} : refine(problem);
  return {std::move(suitable), std::move(finer)};
}

ExposureFit fit_with_eta(const Grid& grid, double eta, const LayeredMedium& start,
                         const ModelError& model_error, const Backend& backend,
                         SolveCount& solves) {
  Problem problem = grid.problem;
  Refinement finer = grid.finer;
  problem.setup.eta = eta;
  finer.setup.eta = eta;
  Objective objective(std::move(problem), backend);
  ExposureFit fit = fit_exposure(objective, finer, start, model_error);
  solves.add(objective.solves());
  return fit;
}

}  // namespace

void Consistency::set_by_volume(const VolumeErrors& found) {
  by_volume = found;
  const double by_shift =
      most_deviations * std::hypot(found.shift_u.error, found.shift_v.error, volume_shift_spread);
  if (is_shifted() && std::hypot(found.shift_u.value, found.shift_v.value) > by_shift) return;
  volume_shift = true;
  shift_u = found.shift_u;
  shift_v = found.shift_v;
  shift_limit = by_shift;
}

bool Consistency::block_scale_is_wrong() const {
  return checked && std::abs(log_scale.value) > log_scale_limit;
}

bool Consistency::is_too_bright() const {
  return by_volume && !is_shifted() && by_volume->scale_gain > most_scale_gain;
}

bool Consistency::scale_is_wrong() const {
  return block_scale_is_wrong() || is_too_bright();
}

bool Consistency::is_shifted() const {
  return checked && std::hypot(shift_u.value, shift_v.value) > shift_limit;
}

std::optional<std::size_t> shifted_channel(std::span<const Consistency> channels) {
  std::optional<std::size_t> least;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto length = [&](std::size_t at) {
      return std::hypot(channels[at].shift_u.value, channels[at].shift_v.value);
    };
    if (!channels[c].checked) continue;
    if (!channels[c].is_shifted()) return std::nullopt;
    if (!least || length(c) < length(*least)) least = c;
  }
  return least;
}

namespace {

Consistency fit_and_compare(const Problem& problem, double kappa, double mu,
                            const ModelError& model_error, const Backend& backend,
                            const std::optional<PhotonOptions>& photons) {
  Consistency result;
  Grid grid = suitable_grid(problem, model_error);
  grid.finer.photons = photons;
  const LayeredMedium start{{0}, {std::log(kappa)}, {std::log(mu)}};
  const double eta = problem.setup.eta;
  const ExposureFit fit = fit_with_eta(grid, eta, start, model_error, backend, result.solves);
  const double voxels = grid.problem.setup.shape.voxel_mm / problem.setup.shape.voxel_mm;
  result.checked = true;
  result.explained = fit.explains;
  result.log_scale = fit.log_scale;
  result.shift_u = {voxels * fit.shift_u.value, voxels * fit.shift_u.error};
  result.shift_v = {voxels * fit.shift_v.value, voxels * fit.shift_v.error};
  result.log_scale_limit = limit(fit.log_scale.error, problem.patterns,
                                 fit.explains ? weak_layers_spread : structure_spread);
  result.shift_limit =
      limit(std::hypot(result.shift_u.error, result.shift_v.error), problem.patterns, shift_spread);
  if (fit.explains || fit.heterogeneity > nearly_even) return result;
  double best = 0.0;
  for (const double other : usual_etas) {
    if (std::abs(other - eta) < same_eta) continue;
    const ExposureFit tried =
        fit_with_eta(grid, other, fit.medium, model_error, backend, result.solves);
    const bool right =
        tried.explains && std::abs(tried.log_scale.value) <=
                              limit(tried.log_scale.error, problem.patterns, calibration_spread);
    if (!right || (result.other_eta && tried.chi2_per_value >= best)) continue;
    result.other_eta = other;
    best = tried.chi2_per_value;
  }
  return result;
}

Consistency with_volume(const FittedVolume& volume, Consistency homogeneous,
                        const ModelError& model_error, const Backend& backend, std::uint64_t seed) {
  const auto [fields, objective] = on_suitable_grid(volume, model_error, backend);
  VolumeErrors found = volume_errors(*objective, fields, volume.prior, volume_steps, seed);
  const double voxels =
      objective->problem().setup.shape.voxel_mm / volume.problem.setup.shape.voxel_mm;
  for (Estimate* shift : {&found.shift_u, &found.shift_v}) {
    shift->value *= voxels;
    shift->error *= voxels;
  }
  homogeneous.set_by_volume(found);
  homogeneous.solves = objective->solves();
  return homogeneous;
}

}  // namespace

Consistency check_volume(const FittedVolume& volume, Consistency homogeneous,
                         const ModelError& model_error, const Backend& backend,
                         std::uint64_t seed) {
  homogeneous.solves = {};
  if (volume.problem.patterns < fewest_patterns) return homogeneous;
  try {
    return with_volume(volume, homogeneous, model_error, backend, seed);
  } catch (const InputError&) {
    return homogeneous;  // no solver converges on a diverged volume
  }
}

Consistency check_consistency(const Problem& problem, double kappa, double mu,
                              const ModelError& model_error, const Backend& backend,
                              const std::optional<PhotonOptions>& photons) {
  if (problem.patterns < fewest_patterns) return {};
  try {
    return fit_and_compare(problem, kappa, mu, model_error, backend, photons);
  } catch (const InputError&) {
    return {};  // a check that fails must not end the fit; warnings_of() reports it
  }
}

}  // namespace kappamu::inverse
