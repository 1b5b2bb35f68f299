// The options of the fit that `kappamu fit` and `kappamu run` share.
#include "app/fit_options.h"

#include <CLI/CLI.hpp>

namespace kappamu::app {

void add_fit_options(CLI::App& command, FitArguments& arguments, const std::string& group) {
  inverse::FitOptions& fit = arguments.stage.fit;
  fit.sensitivity_probes = sensitivity_probes;
  const auto number = [&](const std::string& name, double& value, const std::string& text) {
    command.add_option(name, value, text)->capture_default_str()->group(group);
  };
  command
      .add_option(
          "--optimiser", arguments.optimiser,
          "lbfgs, or wang2008: Polak-Ribière conjugate gradients with golden-section search, "
          "the paper's, many times slower")
      ->check(CLI::IsMember({"lbfgs", "wang2008"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--convention", arguments.convention,
                  "physical, or wang2008: the paper's boundary condition, C = 2.1489")
      ->check(CLI::IsMember({"physical", "wang2008"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--precision", arguments.precision, "Of the solver: single, or double (slower)")
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
      .add_flag("--no-grid-correction", arguments.no_grid_correction,
                "Do not correct for the fitted grid's own error")
      ->group(group);
}

FitStageOptions resolve(const FitArguments& arguments, const Globals& globals) {
  FitStageOptions stage = arguments.stage;
  inverse::FitOptions& fit = stage.fit;
  if (arguments.optimiser == "wang2008") {
    fit.optimiser.method = inverse::Method::wang2008;
    fit.coordinates = inverse::Coordinates::voxels;  // as [W] moves, without a metric
  }
  if (arguments.convention == "wang2008") fit.convention = forward::Convention::wang2008;
  if (arguments.precision == "double") {
    fit.backend.precision = forward::Precision::double_precision;
  }
  fit.correct_grid = !arguments.no_grid_correction;
  fit.backend.device = globals.device;
  fit.seed = globals.seed;
  inverse::validate(fit);
  return stage;
}

}  // namespace kappamu::app
