// What comes of a fit: how it ended, in a sentence, and its volumes.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/shown_text.h"
#include "forward/diffusion_warnings.h"
#include "inverse/fit/channel_run.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/uncertainty/sensitivity.h"

namespace kappamu::inverse {

namespace {

/// What follows "at chi2 per value 1.23" in the sentence on how a fit ended.
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
    case PathEnd::no_gain:
    case PathEnd::lowest:
      break;
  }
  return "";
}

/// χ² per value above which stopping there is worth a warning.
constexpr double suspicious_chi2 = 1.5;

/// What photons were followed in had other coefficients there (photon_ratio.h).
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

/// Of a block thinner than this [transport mean free paths] what passes has hardly scattered.
constexpr double thinnest = 1.5;

std::optional<std::string> hardly_scatters(const Medium& medium, const forward::GridSetup& setup) {
  double mean = 0.0;
  for (const double kappa : medium.kappa.values()) {
    mean += kappa / static_cast<double>(medium.kappa.size());
  }
  const double paths = setup.thickness_mm() / (3.0 * mean);
  if (paths >= thinnest) return std::nullopt;
  return formatted(
      "The block is %.1f transport mean free paths thick: what passes has hardly scattered, so "
      "that "
      "mu is weakly determined, and both coefficients hold for isotropic scattering alone. Measure "
      "a thicker block.",
      paths);
}

}  // namespace

std::vector<std::string> volume_warnings(const Medium& medium, const FitReport& report,
                                         const SurfaceMeasurements& measurements,
                                         const FitOptions& options) {
  const double chi2_per_value = report.chi2_per_value;
  const forward::GridSetup setup = make_setup(measurements, options.data.convention);
  std::vector<std::string> warnings;
  if (report.physics == Physics::diffusion) {
    warnings = forward::diffusion_warnings(setup, medium, options.solver.backend.precision);
  } else {
    for (const auto& sentence : {no_scattering(medium), hardly_scatters(medium, setup)}) {
      if (sentence) warnings.push_back(*sentence);
    }
  }
  if (chi2_per_value > suspicious_chi2) {
    const std::string sentence = formatted(
        "The volumes explain the data only to %.2g times their stated noise (chi2 per "
        "datum %.3g): variances, calibration or the %s model do not hold.",
        std::sqrt(chi2_per_value), chi2_per_value,
        report.physics == Physics::diffusion ? "diffusion" : "transport");
    warnings.insert(warnings.begin(), sentence);
  }
  return warnings;
}

/// How and why the fit ended, once the finest grid is done.
void ChannelRun::conclude() {
  const double chi2 = state_.path.last_chi2;
  const SharedErrors shared = shared_errors_now();
  FitReport& report = state_.report;
  if (out_of_steps()) {
    report.status = FitStatus::ran_out;
    report.reason = formatted("Stopped after %d steps at one weight, at chi2 per value %.3g.",
                              options_.path.stage_steps, chi2);
  } else if (std::max(chi2, shared.excess) <= options_.path.target_chi2 || options_.path.weight) {
    report.status = FitStatus::converged;
    report.reason =
        formatted("Converged at chi2 per value %.3g%s.", chi2, clause(state_.path.end).c_str());
  } else {
    const bool lowest = path_.at_lowest_weight();
    report.status = lowest ? FitStatus::ran_out : FitStatus::above_noise;
    report.reason = formatted("%s at chi2 per value %.3g%s.",
                              lowest ? "The lowest weight was reached"
                                     : "Neither lower weights nor a new correction helped further",
                              chi2, clause(state_.path.end).c_str());
  }
  if (shared.excess > options_.path.target_chi2) {
    report.reason += " Beyond what chance lets them be, " + octave_in_words(shared) + ".";
  }
  if (report.status != FitStatus::ran_out &&
      shared_error() > path_.tolerance() * state_.optimiser.value) {
    report.reason +=
        " What further steps would explain is less than the errors that neighbouring pixels share.";
  }
  finish(chi2);
}

void ChannelRun::finish(double chi2) {
  FitReport& report = state_.report;
  report.chi2_per_value = chi2;
  report.weight = state_.path.weight;
  state_.path.phase = FitPhase::finished;
  state_.optimiser = OptimiserState{};
  state_.blocks.clear();
  state_.scaled_blocks.clear();
  save();
}

/// Whether the images are shifted or too bright, by the volume that was fitted. One that does not
/// explain the data may show a shift but clears them of none: its edges stand for it. [W]'s
/// regulariser says nothing of what volumes are likely.
void ChannelRun::check_data(const std::vector<double>& prediction) {
  if (context_.interim || state_.path.weight <= 0.0 ||
      options_.regulariser.kind == RegulariserKind::wang2008) {
    return;
  }
  progress_.update(stage_name_, 1.0, "asking the volume for a shift and the scale of the images");
  Consistency& consistency = state_.report.consistency;
  const Consistency by_volume = check_volume(
      {grid_.problem(), state_.fields, prediction, prior(), options_.data.term}, consistency,
      options_.data.model_error, options_.solver.backend, options_.solver.seed);
  if (state_.report.chi2_per_value <= suspicious_chi2 || by_volume.is_shifted()) {
    consistency = by_volume;
  } else {
    consistency.by_volume = by_volume.by_volume;
  }
  if (!consistency.block_scale_is_wrong() && consistency.is_too_bright()) {
    warn(brightness_sentence(consistency));
  }
  SolveCount solves = grid_.objective().solves();
  solves.add(by_volume.solves);
  grid_.objective().restore(grid_.objective().correction(), solves);
}

/// By the last prediction.
SharedErrors ChannelRun::shared_errors_now() const {
  return shared_errors(grid_.problem(), options_.data.term, grid_.objective().prediction());
}

/// Of the fit's α at its end.
Prior ChannelRun::prior() const {
  return {state_.path.weight, anchor().length_mm};
}

ChannelFit ChannelRun::result() {
  const CoefficientPair& fields = state_.fields;
  const GridShape& shape = grid_.levels()[0].setup.shape;
  grid_.objective().value(fields);
  ChannelFit fit;
  fit.medium = to_medium(fields, shape);
  if (!context_.interim) {
    for (const std::string& sentence :
         volume_warnings(fit.medium, state_.report, measurements_, options_)) {
      warn(sentence);
    }
  }
  const std::vector<double> prediction = grid_.objective().prediction();
  state_.report.shared = shared_errors_now();
  check_data(prediction);
  for (const double p : prediction) fit.prediction.push_back(static_cast<float>(p / per_value_));
  grid_.objective().count_all_errors();
  const UncertaintyOptions& uncertainty = options_.uncertainty;
  // Models of few unknowns have no weight: theirs is estimate_model_uncertainty(). [W]'s
  // regulariser leaves μ without a prior.
  const bool has_prior = uncertainty.probes > 0 && state_.path.weight > 0.0 &&
                         options_.regulariser.kind != RegulariserKind::wang2008;
  const std::vector<CoefficientPair> rows =
      random_rows(grid_.objective(),
                  std::max(uncertainty.sensitivity_probes, has_prior ? uncertainty.probes : 0),
                  options_.solver.seed);
  if (!rows.empty()) {
    CoefficientPair root = estimate_sensitivity(rows);
    fit.sensitivity_kappa =
        Volume<float>(shape, std::vector<float>(root.log_kappa.begin(), root.log_kappa.end()));
    fit.sensitivity_mu =
        Volume<float>(shape, std::vector<float>(root.log_mu.begin(), root.log_mu.end()));
  }
  if (has_prior) {
    fit.prior = prior();
    const MediumSpace& space = grid_.space();
    fit.blocks = prior_blocks(rows, space);
    fit.missed =
        missed_structure(grid_.objective(), fields,
                         point_spread(prior_metric(*fit.prior, space),
                                      posterior_metric(*fit.prior, space, fit.blocks), space),
                         *fit.prior);
  }
  fit.correction = grid_.objective().correction();
  fit.simpler = state_.simpler;
  fit.report = state_.report;
  fit.report.end = state_.path.end;
  fit.report.backend = grid_.objective().backend_name();
  fit.report.data = grid_.levels()[0].used();
  fit.report.solves = grid_.objective().solves();
  fit.report.seconds = seconds();
  return fit;
}

}  // namespace kappamu::inverse
