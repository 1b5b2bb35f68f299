// Whether a model of few unknowns ends the fit before any voxel has one of its own.

#include "core/shown_text.h"
#include "inverse/block_model/model_choice.h"
#include "inverse/fit/channel_run.h"

namespace kappamu::inverse {

namespace {

std::string described(const ModelTrial& trial) {
  const std::string what =
      trial.layers == 1 ? "a homogeneous block" : std::to_string(trial.layers) + " even layers";
  return formatted("%s (chi2 per value %.3g%s)", what.c_str(), trial.chi2_per_value,
                   trial.level > 0 ? " on a coarser grid" : "");
}

std::string capitalised(std::string sentence) {
  if (sentence.front() >= 'a' && sentence.front() <= 'z') sentence.front() += 'A' - 'a';
  return sentence;
}

/// What the accepted model explains.
std::string explained(const ModelSearch& search) {
  if (!search.systematic) return "the data to their noise";
  return formatted(
      "the data to their noise and a systematic error of %.2g %% (correlated over %.2g "
      "pixels)",
      100.0 * search.systematic->excess, search.systematic->length);
}

/// Why the model of `accepted` was taken, or none; the user asked for `asked`.
std::string reason_of(const ModelSearch& search, Model asked) {
  if (search.accepted && search.accepted->trial.rejected) {
    return capitalised(described(search.accepted->trial)) +
           " was asked for, but does not explain the data to their noise: expect structure that "
           "this volume does not have.";
  }
  if (asked != Model::automatic) return "Asked for; it explains " + explained(search) + ".";
  if (search.accepted && search.accepted->medium.layers() == 1) {
    return capitalised(described(search.accepted->trial)) + " explains " + explained(search) +
           "; more unknowns would only fit that.";
  }
  // The last of each kind was tried on the finest grid that got that far.
  std::string homogeneous, layered;
  for (const ModelTrial& trial : search.trials) {
    if (!trial.rejected) continue;
    (trial.layers == 1 ? homogeneous : layered) = described(trial);
  }
  if (search.accepted) {
    return capitalised(described(search.accepted->trial)) + " explain " + explained(search) + ", " +
           homogeneous + " does not.";
  }
  return capitalised(layered.empty() ? homogeneous + " does not"
                                     : "neither " + homogeneous + " nor " + layered) +
         (layered.empty() ? " explain" : " explains") + " the data to their noise.";
}

}  // namespace

/// Tries the models of few unknowns from the homogeneous start; true where one of them, asked for
/// or not rejected by the data, is the result.
bool ChannelRun::settle_for_simple_model() {
  ModelChoice& choice = state_.report.model;
  if (options_.path.model == Model::volume) {
    choice.reason = "Asked for.";
    return false;
  }
  if (options_.regulariser.kind == RegulariserKind::wang2008) {
    choice.reason = "The paper's fit knows no other.";
    return false;
  }
  ModelSearchOptions options;
  options.asked = options_.path.model;
  options.correct_grid = options_.path.correct_grid;
  options.model_error = options_.data.model_error;
  options.coarse_model_error = options_.data.coarse_model_error;
  options.backend = options_.solver.backend;
  ModelSearch search = search_simple_models(
      grid_.levels(), state_.report.homogeneous_kappa, state_.report.homogeneous_mu,
      grid_.objective().correction(), options,
      [&](const std::string& what) { progress_.update(stage_name_, 0.0, "trying " + what); });
  choice.trials = search.trials;
  choice.reason = reason_of(search, options_.path.model);
  SolveCount solves = grid_.objective().solves();
  solves.add(search.solves);
  if (!search.accepted) {
    for (SimpleFit& fit : search.rejected) state_.simpler.push_back(std::move(fit.medium));
    grid_.objective().restore(grid_.objective().correction(), solves);
    return false;
  }
  SimpleFit& accepted = *search.accepted;
  choice.model = accepted.trial.model;
  choice.layers = accepted.trial.layers;
  if (search.systematic) {
    choice.systematic = search.systematic->excess;
    choice.systematic_length = search.systematic->length;
  }
  open(0);
  grid_.objective().restore(std::move(accepted.correction), solves);
  state_.fields = std::move(accepted.fields);
  state_.path.weight = 0.0;
  state_.path.last_chi2 = accepted.trial.chi2_per_value;
  state_.report.history.push_back(
      {0, 0.0, 0, solves,
       0.5 * state_.path.last_chi2 * static_cast<double>(grid_.levels()[0].used()),
       state_.path.last_chi2, 0.0, seconds()});
  if (observer_) {
    observer_(state_.report.history.back(), grid_.levels()[0].setup.shape, state_.fields);
  }
  conclude_simple(accepted.trial);
  return true;
}

void ChannelRun::conclude_simple(const ModelTrial& trial) {
  FitReport& report = state_.report;
  report.status = trial.rejected ? FitStatus::above_noise : FitStatus::converged;
  report.reason =
      formatted("%s at chi2 per value %.3g.",
                trial.layers == 1 ? "A homogeneous block" : "Even layers", trial.chi2_per_value);
  if (trial.rejected) warn(report.model.reason);
  finish(trial.chi2_per_value);
}

}  // namespace kappamu::inverse
