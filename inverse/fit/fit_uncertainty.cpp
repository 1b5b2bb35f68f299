#include "inverse/fit/fit_uncertainty.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

namespace {

/// 1.234 mm within 0.5 %, or within a factor where a percentage would mislead.
std::string with_error(double log_value, const char* unit, double deviation) {
  constexpr double percent_holds = 0.2;
  if (deviation < percent_holds) {
    return formatted("%.4g%s within %.2g %%", std::exp(log_value), unit, 100.0 * deviation);
  }
  return formatted("%.4g%s within a factor of %.3g", std::exp(log_value), unit,
                   std::exp(deviation));
}

std::string in_words(const LayeredMedium& medium, const Eigen::MatrixXd& covariance,
                     const MediumSpace& space) {
  const double voxel_mm = space.shape.voxel_mm;
  std::string words;
  const Eigen::Index layers = medium.layers();
  for (Eigen::Index l = 0; l < layers; ++l) {
    const auto at = static_cast<std::size_t>(l);
    const Eigen::Index m = layers + l;
    if (layers > 1) {
      const int end = l + 1 < layers ? medium.first[at + 1] : space.depth();
      words += formatted("%s%c from %.3g to %.3g mm: ", l > 0 ? " " : "", "xyz"[space.depth_axis],
                         medium.first[at] * voxel_mm, end * voxel_mm);
    }
    const double kappa = std::sqrt(covariance(l, l));
    const double mu = std::sqrt(covariance(m, m));
    const std::string together = formatted(" (correlation %.2f).", covariance(l, m) / (kappa * mu));
    words += "κ is " + with_error(medium.log_kappa[at], " mm", kappa) + ", μ " +
             with_error(medium.log_mu[at], "/mm", mu) + together;
  }
  return words +
         (layers > 1 ? " One standard deviation, if the block is of these layers"
                     : " One standard deviation, if the block is homogeneous") +
         " and scale, pose and eta are right.";
}

}  // namespace

LayeredMedium layers_of(const Medium& medium, int axis) {
  const GridShape& shape = medium.kappa.shape();
  LayeredMedium layers;
  for (int slice = 0; slice < shape.extent(axis); ++slice) {
    const std::size_t i =
        shape.index(axis == 0 ? slice : 0, axis == 1 ? slice : 0, axis == 2 ? slice : 0);
    const double log_kappa = std::log(medium.kappa[i]);
    const double log_mu = std::log(medium.mu[i]);
    if (slice > 0 && log_kappa == layers.log_kappa.back() && log_mu == layers.log_mu.back()) {
      continue;
    }
    layers.first.push_back(slice);
    layers.log_kappa.push_back(log_kappa);
    layers.log_mu.push_back(log_mu);
  }
  return layers;
}

Uncertainty estimate_model_uncertainty(const ChannelFit& fit, const SurfaceMeasurements& fitted,
                                       int channel, const FitOptions& options) {
  const Stopwatch watch;
  Problem problem =
      make_problem(fitted, channel, options.data.convention, options.data.model_error);
  Refinement finer = refine(problem);
  finer.photons = predict_options(options, fit.report.physics).photons;
  const MediumSpace space = problem.space();
  const GridShape& shape = space.shape;
  const Face seen_face = problem.seen_face;
  const LayeredMedium medium = layers_of(fit.medium, space.depth_axis);
  Objective objective(std::move(problem), options.solver.backend);
  if (options.path.correct_grid) {
    objective.refresh_correction(finer, to_fields(medium, space), Objective::PhotonSlope::renewed);
    objective.count_all_errors();
  }
  objective.value(to_fields(medium, space));
  const std::vector<double> prediction = objective.prediction();
  const SystematicError error = estimate_systematic_error(
      objective.problem(), {prediction, objective.correction().ratio, !finer.photons});
  const Problem& fitted_problem = objective.problem();
  const double lit = fitted_problem.lateral.empty()
                         ? 0.0
                         : LitFace(fitted_problem)
                               .error(std::exp(medium.log_kappa[0]), std::exp(medium.log_mu[0]));
  const double common = std::max(lit, error.found(0.0) ? error.relative : 0.0);
  const Eigen::MatrixXd covariance =
      LayerFitter(objective, medium).covariance({fitted_problem, prediction, error, common});

  LayeredMedium of_kappa = medium;  // deviations in place of values
  LayeredMedium of_both = medium;
  const Eigen::Index layers = medium.layers();
  for (Eigen::Index l = 0; l < layers; ++l) {
    const auto at = static_cast<std::size_t>(l);
    of_kappa.log_kappa[at] = std::sqrt(covariance(l, l));
    of_kappa.log_mu[at] = std::sqrt(covariance(layers + l, layers + l));
    of_both.log_kappa[at] =
        covariance(l, layers + l) / (of_kappa.log_kappa[at] * of_kappa.log_mu[at]);
  }
  const CoefficientPair deviation = to_fields(of_kappa, space);
  const CoefficientPair correlation = to_fields(of_both, space);
  Uncertainty found{Volume<float>(shape),       Volume<float>(shape), Volume<float>(shape, 1.0F),
                    Volume<float>(shape, 1.0F), Volume<float>(shape), {}};
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    found.log_kappa_std[i] = static_cast<float>(deviation.log_kappa[i]);
    found.log_mu_std[i] = static_cast<float>(deviation.log_mu[i]);
    found.correlation[i] = static_cast<float>(correlation.log_kappa[i]);
  }
  found.report.layers = layers_below(found, seen_face);
  found.report.sentence = in_words(medium, covariance, space);
  if (error.found(0.0)) {
    found.report.sentence += formatted(
        " They include a systematic error of the data of %.2g %%, as their residuals "
        "show it.",
        100.0 * error.relative);
  }
  if (lit > 0.0) {
    found.report.sentence += formatted(
        " They include %.2g %% of light that transport's table and the unknown anisotropy (g %.2g "
        "within %.2g) leave open where light falls.",
        100.0 * lit, lit_anisotropy, lit_anisotropy_deviation);
  }
  if (fit.report.status == FitStatus::above_noise) {
    found.report.sentence += " The data are further from it than their noise: so are the errors.";
  }
  found.report.solves = objective.solves().total();
  found.report.seconds = watch.seconds();
  return found;
}

SharedDeviation shared_deviation(std::span<const ChannelFit> fits, Face lit) {
  double contrast = 0.0;
  EvenChange unresolved;
  LayerFreedom freedom;
  for (const ChannelFit& fit : fits) {
    if (!fit.prior) continue;
    freedom.widen(fit.freedom);
    contrast = std::max(contrast, contrast_deviation(fit.medium.kappa, lit));
    unresolved.log_kappa = std::max(unresolved.log_kappa, std::abs(fit.unresolved.log_kappa));
    unresolved.log_mu = std::max(unresolved.log_mu, std::abs(fit.unresolved.log_mu));
  }
  SharedDeviation shared = shared_deviation(contrast, unresolved);
  shared.slice_log_kappa = std::move(freedom.log_kappa);
  shared.slice_log_mu = std::move(freedom.log_mu);
  return shared;
}

Uncertainty estimate_volume_uncertainty(const ChannelFit& fit, const SharedDeviation& shared,
                                        const SurfaceMeasurements& fitted) {
  check(fit.prior.has_value(), "uncertainty: the fit has no prior");
  const auto as_vector = [](const Volume<float>& volume) {
    return Vector(volume.values().begin(), volume.values().end());
  };
  return estimate_uncertainty(
      *fit.prior, forward::block_space(fitted.grid, fitted.lit_face), fitted.seen_face, fit.blocks,
      {as_vector(fit.sensitivity_kappa), as_vector(fit.sensitivity_mu)}, shared);
}

}  // namespace kappamu::inverse
