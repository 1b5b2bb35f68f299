// The options of the fit that `kappamu fit` and `kappamu run` share.
#pragma once

#include <map>
#include <string>

#include "app/command.h"
#include "app/fit_stage.h"

namespace kappamu::app {

/// Adjoint solves the commands spend on where the data constrain the volume.
inline constexpr int sensitivity_probes = 8;

/// Samples the commands spend on the volumes' uncertainty.
inline constexpr int uncertainty_samples = 2;

/// As parsed; resolve() makes options of it.
struct FitArguments {
  std::string model = "auto";
  std::string optimiser = "lbfgs";
  std::string convention = "physical";
  std::string precision = "single";
  std::string loss = "gaussian";
  std::string regulariser = "h1";
  std::string choose_weight = "discrepancy";
  double gains = 0.0;  ///< spread; 0: none
  bool no_grid_correction = false;
  FitStageOptions stage;
};

/// Adds the options to `command`, listed under `group`; `arguments` outlives the parse.
void add_fit_options(CLI::App& command, FitArguments& arguments, const std::string& group);

/// Every option that the volumes depend on, by name: one flat JSON object, equal for equal options.
/// The key of the fit stage, run.json, fit.json and the report are all made of it.
std::string options_json(const FitStageOptions& options);

/// The same by name, each value as JSON writes it.
std::map<std::string, std::string> options_by_name(const FitStageOptions& options);

/// Options of the fit stage. Throws InputError naming option, value and bound.
FitStageOptions resolve(const FitArguments& arguments, const Globals& globals);

}  // namespace kappamu::app
