#include "inverse/fit/start.h"

#include "core/shown_text.h"

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

/// The data as the accepted model explains them.
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

std::optional<SimpleFit> choose_simple_model(FitRun& run) {
  const FitOptions& options = run.options;
  ModelChoice& choice = run.state.report.model;
  if (options.path.model == Model::volume) {
    choice.reason = "Asked for.";
    return std::nullopt;
  }
  if (options.regulariser.kind == RegulariserKind::wang2008) {
    choice.reason = "The paper's fit knows no other.";
    return std::nullopt;
  }
  ModelSearchOptions how;
  how.asked = options.path.model;
  how.correct_grid = options.path.correct_grid;
  how.model_error = options.data.model_error;
  how.coarse_model_error = options.data.coarse_model_error;
  how.backend = options.solver.backend;
  const FitReport& report = run.state.report;
  ModelSearch search = search_simple_models(
      run.grid.levels(), report.homogeneous_kappa, report.homogeneous_mu,
      run.grid.objective().correction(), how,
      [&](const std::string& what) { run.progress.update(run.stage_name, 0.0, "trying " + what); });
  choice.trials = search.trials;
  choice.reason = reason_of(search, options.path.model);
  run.count(search.solves);
  if (!search.accepted) {
    for (SimpleFit& fit : search.rejected) run.state.simpler.push_back(std::move(fit.medium));
    return std::nullopt;
  }
  choice.model = search.accepted->trial.model;
  choice.layers = search.accepted->trial.layers;
  if (search.systematic) {
    choice.systematic = search.systematic->excess;
    choice.systematic_length = search.systematic->length;
  }
  return std::move(search.accepted);
}

void conclude_simple(FitRun& run, SimpleFit simple) {
  const ModelTrial& trial = simple.trial;
  const SolveCount solves = run.grid.objective().solves();
  run.open(0);
  run.grid.objective().restore(std::move(simple.correction), solves);
  FitState& state = run.state;
  state.fields = std::move(simple.fields);
  state.last_chi2 = trial.chi2_per_value;
  const auto values = static_cast<double>(run.grid.problem().used());
  run.record(
      {.objective = 0.5 * trial.chi2_per_value * values, .chi2_per_value = trial.chi2_per_value},
      state.fields);
  FitReport& report = state.report;
  report.status = trial.rejected ? FitStatus::above_noise : FitStatus::converged;
  report.reason =
      formatted("%s at chi2 per value %.3g.",
                trial.layers == 1 ? "A homogeneous block" : "Even layers", trial.chi2_per_value);
  if (trial.rejected) run.warn(report.model.reason);
}

}  // namespace kappamu::inverse
