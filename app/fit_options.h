// The options of the fit that `kappamu fit` and `kappamu run` share.
#pragma once

#include <string>

#include "app/command.h"
#include "app/fit_stage.h"

namespace kappamu::app {

/// Adjoint solves the commands spend on where the data constrain the volume.
inline constexpr int sensitivity_probes = 8;

/// As parsed; resolve() makes options of it.
struct FitArguments {
  std::string optimiser = "lbfgs";
  std::string convention = "physical";
  std::string precision = "single";
  bool no_grid_correction = false;
  FitStageOptions stage;
};

/// Adds the options to `command`, listed under `group`; `arguments` outlives the parse.
void add_fit_options(CLI::App& command, FitArguments& arguments, const std::string& group);

/// Options of the fit stage. Throws InputError naming option, value and bound.
FitStageOptions resolve(const FitArguments& arguments, const Globals& globals);

}  // namespace kappamu::app
