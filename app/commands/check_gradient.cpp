#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "core/error.h"
#include "inverse/data_checks/gradient_check.h"
#include "io/measurements_file.h"
#include "pipeline/fit_files.h"
#include "pipeline/stages/fit_stage.h"

namespace kappamu::app {

namespace {

using Json = nlohmann::ordered_json;

struct CheckOptions {
  std::string input;
  std::vector<std::string> channels;
};

Json to_json(const std::string& channel, const inverse::GradientCheck& check) {
  Json taylor = Json::array();
  for (const inverse::TaylorStep& step : check.taylor) {
    taylor.push_back({{"step", step.step}, {"remainder", step.remainder}, {"order", step.order}});
  }
  return {{"name", channel},
          {"holds", check.holds()},
          {"taylor", taylor},
          {"worst_order_error", check.worst_order_error},
          {"adjoint_error", check.adjoint_error},
          {"symmetry_error", check.symmetry_error},
          {"batched_solves", check.solves.forward + check.solves.adjoint},
          {"device", check.backend}};
}

const char* verdict(bool holds) {
  return holds ? "holds" : "FAILS";
}

void print(const std::string& channel, const inverse::GradientCheck& check) {
  std::printf("%s on %s\n  Taylor remainder %s: order", channel.c_str(), check.backend.c_str(),
              verdict(check.taylor_holds()));
  for (std::size_t k = 1; k < check.taylor.size(); ++k) {
    std::printf(" %.3f", check.taylor[k].order);
  }
  std::printf(" from step %.0e to %.0e (2 within %.2f)\n", check.taylor.front().step,
              check.taylor.back().step, inverse::GradientBounds::order);
  std::printf("  adjoint of the Jacobian %s: %.1e (within %.0e)\n", verdict(check.adjoint_holds()),
              check.adjoint_error, inverse::GradientBounds::adjoint);
  std::printf("  symmetry of the solver %s: %.1e (within %.0e)\n", verdict(check.symmetry_holds()),
              check.symmetry_error, inverse::GradientBounds::symmetry);
}

void run_check(const CheckOptions& options, Globals& globals) {
  const auto progress = make_progress();
  const auto folder = pipeline::find_measurements(options.input);
  const SurfaceMeasurements measurements = io::read_measurements(folder);
  const auto& names = measurements.channels;
  for (const std::string& wanted : options.channels) {
    if (std::find(names.begin(), names.end(), wanted) == names.end()) {
      throw InputError(folder.string() + ": has no channel '" + wanted + "'; pass one of its own");
    }
  }
  Json channels = Json::array();
  bool holds = true;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const auto& wanted = options.channels;
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), names[c]) == wanted.end()) {
      continue;
    }
    progress->update("check gradient", static_cast<double>(c) / static_cast<double>(names.size()),
                     names[c]);
    const inverse::FitOptions defaults;
    const inverse::GradientCheck check = inverse::check_gradient(
        inverse::make_problem(measurements, static_cast<int>(c), defaults.data.convention,
                              defaults.data.model_error),
        globals.device, globals.seed);
    if (!check.warning.empty()) progress->warn(check.warning);
    holds = holds && check.holds();
    channels.push_back(to_json(names[c], check));
    if (!globals.json) print(names[c], check);
  }
  if (globals.json) {
    print_json({{"holds", holds}, {"channels", channels}});
  } else {
    std::printf("%s\n", holds ? "The gradient is that of the objective on these data."
                              : "The gradient is NOT that of the objective on these data: do not "
                                "trust a fit on this device; try --device reference.");
  }
  if (!holds) globals.exit_code = 1;
}

}  // namespace

void add_check_gradient(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("check-gradient",
                         R"(Test the fit's gradient and adjoint on your own measurements.

INPUT is a folder with measurements.json or a run that `kappamu merge` filled. At the best
homogeneous block, with every voxel varied by 20 %, along a random direction (--seed):
  Taylor    J(u + s d) - J(u) - s <gradient, d> falls as s squared, over three decades
  adjoint   the Jacobian by differences of predictions and its transpose by the adjoint
            solve agree on random vectors
  symmetry  <inverse(A) b, w> = <b, inverse(A) w>
All in double precision on the device that --device chooses: some 30 solves of all
patterns.)");
  auto options = std::make_shared<CheckOptions>();
  command->add_option("input", options->input, "Folder of measurements, or run folder")
      ->required()
      ->type_name("INPUT");
  command
      ->add_option("--channel", options->channels,
                   "Check this channel only; may be given several times")
      ->type_name("NAME");
  command->footer(
      "Exit codes: 0 all hold, 1 one fails or bad input, 2 usage.\n"
      "Example: kappamu check-gradient demo/run");
  command->callback([options, &globals] { run_check(*options, globals); });
}

}  // namespace kappamu::app
