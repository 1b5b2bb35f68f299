#include "inverse/fit/conclusion.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/diffusion_warnings.h"
#include "inverse/data_checks/coarser_volume.h"
#include "inverse/defaults.h"
#include "inverse/fit/fit_uncertainty.h"
#include "inverse/optimise/lateral_hessian.h"

namespace kappamu::inverse {

namespace {

/// The clause after "at chi2 per value 1.23" in the sentence on the end of a fit.
std::string clause(PathEnd end) {
  switch (end) {
    case PathEnd::noise:
      return ", the noise of the data";
    case PathEnd::validated:
      return "; under less smoothing cross-validation expects no less error of other light";
    case PathEnd::model_error:
      return "; under less smoothing cross-validation expects more error of other light";
    case PathEnd::unknown:
    case PathEnd::asked:
    case PathEnd::lowest:
      break;
  }
  return "";
}

/// Photons were followed through other coefficients there (photon_ratio.h).
std::optional<std::string> no_scattering(const Medium& medium) {
  std::size_t without = 0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    without += 3.0 * medium.kappa[i] * medium.mu[i] >= 1.0 ? 1 : 0;
  }
  if (without == 0) return std::nullopt;
  return "In " + std::to_string(without) +
         " voxels no scattering is left (3 kappa mu >= 1), which transport cannot read: it took "
         "them for almost pure absorbers.";
}

std::optional<std::string> thin_block(const Medium& medium, const forward::GridSetup& setup,
                                      double anisotropy) {
  double mean = 0.0;
  for (const double kappa : medium.kappa.values()) {
    mean += kappa / static_cast<double>(medium.kappa.size());
  }
  const double paths = setup.thickness_mm() / (3.0 * mean);
  if (paths >= defaults::thinnest) return std::nullopt;
  const std::string scattering =
      anisotropy == 0.0 ? "isotropic scattering" : "an anisotropy of " + shown_number(anisotropy);
  return formatted(
      "The block is %.1f transport mean free paths thick: much of the light passes unscattered, "
      "so that mu is weakly determined, and both coefficients hold for %s alone. Measure a thicker "
      "block.",
      paths, scattering.c_str());
}

/// Light that leaves the profile along the depth open.
std::optional<std::string> profile_undetermined(const LayerFreedom& freedom) {
  const double factor = std::exp(freedom.least_log_mu());
  if (factor <= defaults::summary::undetermined_factor) return std::nullopt;
  return formatted(
      "This light determines mu of no layer better than within a factor of %.2g (one standard "
      "deviation), because a block of another profile along the depth would show the same. Light "
      "it by bars or patches, or from the other side.",
      factor);
}

bool uses_lit_pixels(const SurfaceMeasurements& m) {
  for (std::size_t i = 0; i < m.lit.size(); ++i) {
    if (m.lit[i] != 0 && m.mask[i] != 0) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> volume_warnings(const Medium& medium, const FitReport& report,
                                         const SurfaceMeasurements& measurements,
                                         const FitOptions& options) {
  const double chi2_per_value = report.chi2_per_value;
  const forward::GridSetup setup = make_setup(measurements, options.data.convention);
  std::vector<std::string> warnings;
  if (report.physics == Physics::diffusion) {
    if (!uses_lit_pixels(measurements)) {  // whose light is by transport
      warnings = forward::diffusion_warnings(setup, medium, options.solver.backend.precision);
    }
  } else {
    for (const auto& sentence :
         {no_scattering(medium), thin_block(medium, setup, options.data.anisotropy)}) {
      if (sentence) warnings.push_back(*sentence);
    }
  }
  if (chi2_per_value > defaults::suspicious_chi2) {
    const std::string sentence = formatted(
        "The volumes explain the data only to %.2g times their stated noise (chi2 per "
        "datum %.3g): variances, calibration or the %s model do not hold.",
        std::sqrt(chi2_per_value), chi2_per_value,
        report.physics == Physics::diffusion ? "diffusion" : "transport");
    warnings.insert(warnings.begin(), sentence);
  }
  return warnings;
}

void conclude_path(const PathOptions& path, const EndedPath& ended, FitReport& report) {
  if (ended.ran_out) {
    report.status = FitStatus::ran_out;
    report.reason = formatted("Stopped after %d steps at one weight, at chi2 per value %.3g.",
                              path.stage_steps, ended.chi2);
  } else if (std::max(ended.chi2, ended.excess) <= path.target_chi2 || path.weight) {
    report.status = FitStatus::converged;
    report.reason =
        formatted("Converged at chi2 per value %.3g%s.", ended.chi2, clause(ended.end).c_str());
  } else {
    const bool lowest = ended.weight * path.weight_factor < path.last_weight;
    report.status = lowest ? FitStatus::ran_out : FitStatus::above_noise;
    report.reason = formatted("%s at chi2 per value %.3g%s.",
                              lowest ? "The lowest weight was reached"
                                     : "Neither lower weights nor a new correction helped further",
                              ended.chi2, clause(ended.end).c_str());
  }
}

void conclude(FitRun& run, const Stage& stage) {
  const FitState& state = run.state;
  const PathOptions& path = run.options.path;
  const double chi2 = state.last_chi2;
  const SharedErrors shared = shared_errors_now(run);
  FitReport& report = run.state.report;
  conclude_path(path, {chi2, shared.excess, state.weight, state.end, stage.ran_out}, report);
  if (shared.excess > path.target_chi2) {
    report.reason += " Beyond what chance lets them be, " + octave_in_words(shared) + ".";
  }
  if (report.status != FitStatus::ran_out &&
      shared_error(run.grid.problem()) > tolerance(path, state.last) * stage.optimiser.value) {
    report.reason +=
        " What further steps would explain is less than the errors that neighbouring pixels share.";
  }
}

void check_data(FitRun& run) {
  const FitOptions& options = run.options;
  if (run.context.interim || run.state.weight <= 0.0 ||
      options.regulariser.kind == RegulariserKind::wang2008) {
    return;
  }
  run.progress.update(run.stage_name, 1.0,
                      "asking the volume for a shift and the scale of the images");
  Consistency& consistency = run.state.report.consistency;
  const std::vector<double> prediction = run.grid.objective().prediction();
  const Consistency by_volume = check_volume(
      {run.grid.problem(), run.state.fields, prediction, prior_of(run), options.data.term},
      consistency, options.data.model_error, options.solver.backend, options.solver.seed);
  if (run.state.report.chi2_per_value <= defaults::suspicious_chi2 || by_volume.is_shifted()) {
    consistency = by_volume;
  } else {
    consistency.by_volume = by_volume.by_volume;
  }
  if (!consistency.block_scale_is_wrong() && consistency.is_too_bright()) {
    run.warn(brightness_sentence(consistency));
  }
  run.count(by_volume.solves);
}

namespace {

/// Whether `freedom` shows in deviations beside what else this channel makes of them, or comes near
/// the warning.
bool matters(const LayerFreedom& freedom, const SharedDeviation& beside) {
  const auto exceeds = [](const Vector& slices, double deviation) {
    return std::any_of(slices.begin(), slices.end(), [&](double f) { return f > deviation; });
  };
  const double near_warning = 0.7 * std::log(defaults::summary::undetermined_factor);
  return exceeds(freedom.log_kappa, beside.log_kappa) || exceeds(freedom.log_mu, beside.log_mu) ||
         freedom.least_log_mu() > near_warning;
}

/// By solves on voxels of twice the edge, which cost an eighth and state too much of κ next to the
/// seen face; where that matters, on the fit's own.
LayerFreedom freedom_of(FitRun& run, const ChannelFit& fit) {
  Objective& objective = run.grid.objective();
  const FitOptions& options = run.options;
  const Backend& backend = options.solver.backend;
  const std::vector<double> prediction = objective.prediction();
  try {
    const CoarserVolume coarser = on_suitable_grid(
        {objective.problem(), run.state.fields, prediction, prior_of(run), options.data.term},
        options.data.model_error, backend);
    coarser.objective->set_derivative_tolerance(derivative_tolerance(backend));
    const LayerFreedom freedom = layer_freedom(*coarser.objective, run.grid.space());
    run.count(coarser.objective->solves());
    if (!matters(freedom, shared_deviation({&fit, 1}, run.measurements.lit_face))) return freedom;
  } catch (const InputError&) {
    // Averaged, a volume may defy the solver.
  }
  return layer_freedom(objective, run.grid.space());
}

}  // namespace

void find_deviations(FitRun& run, ChannelFit& fit) {
  Objective& objective = run.grid.objective();
  const MediumSpace& space = run.grid.space();
  objective.count_all_errors();
  const UncertaintyOptions& uncertainty = run.options.uncertainty;
  // Models of few unknowns have no weight: theirs is estimate_model_uncertainty(). [W]'s
  // regulariser leaves μ without a prior.
  const bool has_prior = uncertainty.probes > 0 && run.state.weight > 0.0 &&
                         run.options.regulariser.kind != RegulariserKind::wang2008;
  const std::vector<CoefficientPair> rows = random_rows(
      objective, std::max(uncertainty.sensitivity_probes, has_prior ? uncertainty.probes : 0),
      run.options.solver.seed);
  if (!rows.empty()) {
    const auto volume = [&](const Vector& root) {
      return Volume<float>(space.shape, std::vector<float>(root.begin(), root.end()));
    };
    const CoefficientPair root = estimate_sensitivity(rows);
    fit.sensitivity_kappa = volume(root.log_kappa);
    fit.sensitivity_mu = volume(root.log_mu);
  }
  if (!has_prior) return;
  fit.prior = prior_of(run);
  fit.blocks = prior_blocks(rows, space);
  fit.unresolved =
      unresolved_structure(objective, run.state.fields,
                           point_spread(prior_metric(*fit.prior, space),
                                        posterior_metric(*fit.prior, space, fit.blocks), space),
                           *fit.prior);
  fit.freedom = freedom_of(run, fit);
  const auto sentence = profile_undetermined(fit.freedom);
  if (sentence && !run.context.interim) run.warn(*sentence);
}

}  // namespace kappamu::inverse
