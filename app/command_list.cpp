#include "app/command_list.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <vector>

namespace kappamu::app {

namespace {

struct Group {
  const char* name;
  std::vector<void (*)(CLI::App&, Globals&)> commands;
};

}  // namespace

std::string positive_number(const std::string& text) {
  double value = 0.0;
  if (CLI::detail::lexical_cast(text, value) && value > 0.0 && std::isfinite(value)) return {};
  return "'" + text + "' is no positive number";
}

void add_out(CLI::App& command, std::string& out, const std::string& text,
             const std::string& type) {
  command.add_option("-o,--out", out, text)->required()->type_name(type);
}

void add_most_voxels(CLI::App& command, std::size_t& most) {
  command
      .add_option("--max-voxels", most,
                  "Refuse a volume file with more numbers than this in all its volumes together")
      ->capture_default_str()
      ->type_name("N");
}

void add_commands(CLI::App& app, Globals& globals) {
  app.name("kappamu");
  app.description(
      "kappamu: from photographs of a translucent block to its diffusion and absorption "
      "coefficients");
  app.footer(
      "kappamu COMMAND --help is the command's manual page.\n"
      "Exit codes: 0 done, 1 failed (one sentence), 2 usage, 3 not converged or not to be "
      "trusted.\n"
      "Start with: kappamu simulate --sample demo -o demo && kappamu run demo/session -o demo/run");
  const std::vector<Group> groups{
      {"Capture", {add_plan, add_import, add_simulate, add_calibrate, add_merge, add_chart}},
      {"Fit", {add_run, add_fit, add_map}},
      {"Use", {add_edit, add_export, add_render, add_view, add_forward}},
      {"Check", {add_report, add_verify, add_score, add_bench, add_doctor}}};
  for (const Group& group : groups) {
    for (const auto add : group.commands) {
      add(app, globals);
      app.get_subcommands({}).back()->group(group.name);
    }
  }
}

}  // namespace kappamu::app
