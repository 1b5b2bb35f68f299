#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/command.h"
#include "app/fit_stage.h"

namespace kappamu::app {

namespace {

using Json = nlohmann::ordered_json;

struct FitCommand {
  std::string input;
  std::string out;
  std::string validate;
  std::string optimiser = "lbfgs";
  std::string convention = "physical";
  std::string precision = "single";
  bool no_grid_correction = false;
  FitStageOptions stage;
};

inverse::FitOptions resolved(const FitCommand& command, const Globals& globals) {
  inverse::FitOptions fit = command.stage.fit;
  if (command.optimiser == "wang2008") {
    fit.optimiser.method = inverse::Method::wang2008;
    fit.coordinates = inverse::Coordinates::voxels;  // as [W] moves, without a metric
  }
  if (command.convention == "wang2008") fit.convention = forward::Convention::wang2008;
  if (command.precision == "double") {
    fit.backend.precision = forward::Precision::double_precision;
  }
  fit.correct_grid = !command.no_grid_correction;
  fit.backend.device = globals.device;
  fit.seed = globals.seed;
  return fit;
}

int evaluations(const inverse::FitReport& report) {
  return report.history.empty() ? 0 : report.history.back().solves.adjoint;
}

Json to_json(const FitSummary& summary) {
  Json channels = Json::array();
  for (std::size_t c = 0; c < summary.channels.size(); ++c) {
    const inverse::FitReport& r = summary.reports[c];
    channels.push_back({{"name", summary.channels[c]},
                        {"status", inverse::to_string(r.status)},
                        {"chi2_per_value", r.chi2_per_datum},
                        {"evaluations", evaluations(r)},
                        {"seconds", r.seconds}});
    if (!summary.holdout_error.empty()) {
      channels.back()["holdout_E"] = summary.holdout_error[c];
      channels.back()["holdout_noise"] = summary.holdout_noise[c];
    }
  }
  return {{"converged", summary.converged()},
          {"volume", summary.volume.string()},
          {"device", summary.device},
          {"channels", channels},
          {"seconds", summary.seconds}};
}

void print_table(const FitSummary& summary) {
  for (std::size_t c = 0; c < summary.channels.size(); ++c) {
    const inverse::FitReport& r = summary.reports[c];
    std::printf("%-5s chi2 per value %-8.3g %4d gradients  %6.1f s", summary.channels[c].c_str(),
                r.chi2_per_datum, evaluations(r), r.seconds);
    if (!summary.holdout_error.empty()) {
      std::printf("  held-out E %.2e (noise %.1e)", summary.holdout_error[c],
                  summary.holdout_noise[c]);
    }
    std::printf("  %s\n", r.message.c_str());
  }
  std::printf("%s\n", summary.volume.c_str());
}

void run_fit(const FitCommand& command, Globals& globals) {
  const auto progress = make_progress();
  FitStageOptions options = command.stage;
  options.fit = resolved(command, globals);
  if (!command.validate.empty()) options.validate = command.validate;
  const FitSummary summary = run_fit_stage(command.input, command.out, options, *progress);
  if (globals.json) {
    std::printf("%s\n", to_json(summary).dump().c_str());
  } else {
    print_table(summary);
  }
  if (!summary.converged()) globals.exit_code = 3;
}

void add_expert_options(CLI::App& command, FitCommand& options) {
  inverse::FitOptions& fit = options.stage.fit;
  const std::string group = "For comparisons and difficult data";
  const auto number = [&](const std::string& name, double& value, const std::string& text) {
    command.add_option(name, value, text)->capture_default_str()->group(group);
  };
  command
      .add_option(
          "--optimiser", options.optimiser,
          "lbfgs, or wang2008: Polak-Ribière conjugate gradients with golden-section search, "
          "the paper's, many times slower")
      ->check(CLI::IsMember({"lbfgs", "wang2008"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--convention", options.convention,
                  "physical, or wang2008: the paper's boundary condition, C = 2.1489")
      ->check(CLI::IsMember({"physical", "wang2008"}))
      ->capture_default_str()
      ->group(group);
  command.add_option("--precision", options.precision, "Of the solver: single, or double (slower)")
      ->check(CLI::IsMember({"single", "double"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option_function<double>(
          "--weight", [&fit](double w) { fit.weight = w; },
          "Smooth with this weight only, instead of lowering it to the noise level")
      ->group(group);
  number("--target-chi2", fit.target_chi2,
         "Lower the weight until chi2 per value is this; above 1 for a smoother volume");
  number("--model-error", fit.model_error.relative,
         "Error of the model relative to each value, added to its standard deviation");
  number("--model-error-floor", fit.model_error.of_maximum,
         "The same relative to the largest value of each pattern");
  number("--stage-tolerance", fit.stage_tolerance,
         "Relative decrease of the objective per step below which a weight is done");
  command.add_option("--stage-steps", fit.stage_steps, "Most steps at one weight")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--levels", fit.max_levels,
                  "Grids from coarse to fine; 1 fits on the full grid at once")
      ->capture_default_str()
      ->group(group);
  command
      .add_flag("--no-grid-correction", options.no_grid_correction,
                "Do not correct for the fitted grid's own error")
      ->group(group);
}

}  // namespace

void add_fit(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "fit",
      "Find the volumes of κ and μ that explain surface measurements.\n\n"
      "INPUT is a folder with measurements.json (docs/formats.md) from any rig or program, or a "
      "run\n"
      "that `kappamu merge` filled. Each channel is fitted on its own: the best homogeneous block\n"
      "first, then coarse grid to fine, the smoothing lowered until the residuals are as large as\n"
      "the measurements' own noise.\n\n"
      "Writes OUT/kappa_<channel>.npy [mm] and mu_<channel>.npy [1/mm], float32 [z][y][x],\n"
      "sensitivity_<channel>.npy, prediction.npy, prediction_validate.npy, volume.vdb and "
      "fit.json.\n"
      "Killed at any moment and started again with the same command it goes on where it was and\n"
      "ends in the same volumes.\n\n"
      "Reading the result: chi2 per value near 1 means that the volumes explain the data to their\n"
      "stated noise; well above 1, variances, calibration or the diffusion model do not hold. "
      "What\n"
      "counts is held-out E = Σ(L' − L)²/ΣL², the error under light the fit never saw, beside the\n"
      "part of it that the held-out measurements' own noise explains. Light at steady state does\n"
      "not determine deep voxels: where sensitivity is small against its largest value, κ and μ\n"
      "are the smoothing's choice.");
  auto options = std::make_shared<FitCommand>();
  options->stage.fit.sensitivity_probes = 8;
  command->add_option("input", options->input, "Folder of measurements, or run folder")
      ->required()
      ->type_name("INPUT");
  command->add_option("-o,--out", options->out, "Folder for the results; made if missing")
      ->required()
      ->type_name("OUT");
  command
      ->add_option("--channel", options->stage.channels,
                   "Fit this channel only; may be given several times")
      ->type_name("NAME");
  command
      ->add_option("--validate", options->validate,
                   "Measurements of held-out patterns to predict and score (default: "
                   "INPUT/measurements_validate)")
      ->type_name("FOLDER");
  command->add_flag("--restart", options->stage.restart, "Ignore the checkpoints in OUT");
  add_expert_options(*command, *options);
  command->footer(
      "Exit code 3: some channel ran out of steps; its volumes are kept and marked in fit.json.\n"
      "Example: kappamu fit demo/run -o demo/run/fit");
  command->callback([options, &globals] { run_fit(*options, globals); });
}

}  // namespace kappamu::app
