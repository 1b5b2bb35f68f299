#include "app/command_list.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace kappamu::app {

namespace {

/// A line per command: the first paragraph of its manual page.
class OneLineEach : public CLI::Formatter {
 public:
  std::string make_subcommand(const CLI::App* command) const override {
    constexpr std::size_t name_width = 17;
    std::string text = command->get_description();
    text = text.substr(0, text.find("\n\n"));
    std::replace(text.begin(), text.end(), '\n', ' ');
    std::string name = "  " + command->get_name();
    name.resize(std::max(name_width, name.size() + 1), ' ');
    return name + text + "\n";
  }
};

struct Group {
  const char* name;
  std::vector<void (*)(CLI::App&, Globals&)> commands;
};

}  // namespace

void print_json(const nlohmann::ordered_json& object) {
  std::printf("%s\n",
              object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
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
  app.formatter(std::make_shared<OneLineEach>());
  const std::vector<Group> groups{
      {"Capture", {add_plan, add_import, add_simulate, add_calibrate, add_merge, add_chart}},
      {"Fit", {add_run, add_fit}},
      {"Use", {add_edit, add_export, add_render, add_view, add_forward}},
      {"Check", {add_report, add_verify, add_score, add_check_gradient, add_bench, add_doctor}}};
  for (const Group& group : groups) {
    for (const auto add : group.commands) {
      add(app, globals);
      app.get_subcommands({}).back()->group(group.name);
    }
  }
}

}  // namespace kappamu::app
