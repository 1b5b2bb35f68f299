#include "python/bindings/call.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/command_list.h"
#include "core/error.h"
#include "pipeline/records/fit_options.h"

namespace kappamu::python {

namespace {

using Json = nlohmann::ordered_json;
using Keys = std::map<std::string, std::string>;  ///< of a fit's options by their flags

Keys keys_of_fit() {
  Keys keys;
  pipeline::FitStageOptions options;
  pipeline::describe(options, [&keys](const Option& option, auto&...) {
    const std::string flags = option.flag;
    if (!flags.empty()) keys[flags.substr(0, flags.find(','))] = option.name;
  });
  return keys;
}

bool is_flag(const CLI::Option& option) {
  return option.get_items_expected_max() == 0;
}

/// A flag that clears what is on without it.
bool clears(const CLI::Option& option) {
  return is_flag(option) && option.get_lnames().front().starts_with("no-");
}

std::string flag_of(const CLI::Option& option) {
  return option.get_lnames().empty() ? option.get_name(true) : "--" + option.get_lnames().front();
}

std::string key_of(const CLI::Option& option, const Keys& of_fit) {
  const std::string flag = flag_of(option);
  if (const auto known = of_fit.find(flag); known != of_fit.end()) return known->second;
  std::string key = option.get_lnames().empty() ? flag : option.get_lnames().front();
  if (clears(option)) key = key.substr(3);
  std::replace(key.begin(), key.end(), '-', '_');
  return key;
}

/// Help and --json are the terminal's; an option without a group is for the documents.
bool is_for_programs(const CLI::Option& option) {
  const std::string flag = flag_of(option);
  return flag != "--help" && flag != "--json" && flag != "--version" && !option.get_group().empty();
}

Json describe(const CLI::Option& option, const Keys& of_fit) {
  return {{"key", key_of(option, of_fit)},
          {"flag", flag_of(option)},
          {"text", option.get_description()},
          {"default", option.get_default_str()},
          {"type", option.get_type_name()},
          {"group", option.get_group()},
          {"required", option.get_required()},
          {"positional", option.get_positional()},
          {"kind", !is_flag(option) ? "value"
                   : clears(option) ? "off"
                                    : "on"},
          {"least", option.get_items_expected_min()},
          {"most", option.get_items_expected_max()}};
}

/// The options that `command` and the program take.
std::vector<CLI::Option*> options_of(CLI::App& program, CLI::App& command) {
  const auto wanted = [](const CLI::Option* option) { return is_for_programs(*option); };
  std::vector<CLI::Option*> options = command.get_options(wanted);
  for (CLI::Option* option : program.get_options(wanted)) options.push_back(option);
  return options;
}

void set_up(CLI::App& program, app::Globals& globals) {
  globals.json = true;
  program.require_subcommand(1);
  program.fallthrough();
  app::add_globals(program, globals);
  app::add_commands(program, globals);
}

void give(CLI::Option& option, const std::vector<std::string>& words) {
  if (is_flag(option)) {
    option.add_result(option.get_flag_value(option.get_lnames().front(), ""));
  } else {
    option.add_result(words);
  }
}

}  // namespace

Json describe_commands() {
  CLI::App program;
  app::Globals globals;
  set_up(program, globals);
  const Keys of_fit = keys_of_fit();
  const Keys none;
  Json commands = Json::array();
  for (CLI::App* command : program.get_subcommands({})) {
    const bool fits = command->get_name() == "fit" || command->get_name() == "run";
    Json options = Json::array();
    for (const CLI::Option* option : options_of(program, *command))
      options.push_back(describe(*option, fits ? of_fit : none));
    commands.push_back({{"name", command->get_name()},
                        {"group", command->get_group()},
                        {"text", command->get_description()},
                        {"footer", command->get_footer()},
                        {"options", options}});
  }
  return commands;
}

int call_command(const std::string& name, const CommandValues& values, app::Caller& caller) {
  const app::CalledBy called(caller);
  CLI::App program;
  app::Globals globals;
  set_up(program, globals);
  const auto commands =
      program.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  if (commands.empty()) throw InputError("there is no command '" + name + "'");
  CLI::App* const command = commands.front();
  const bool fits = name == "fit" || name == "run";
  const Keys of_fit = fits ? keys_of_fit() : Keys();
  const std::vector<CLI::Option*> options = options_of(program, *command);
  try {
    for (const auto& [key, words] : values) {
      const auto found = std::find_if(
          options.begin(), options.end(),
          [&, k = key](const CLI::Option* option) { return key_of(*option, of_fit) == k; });
      if (found == options.end()) throw InputError("'" + name + "' has no option " + key);
      give(**found, words);
    }
    program.parse(std::vector<std::string>{name});
  } catch (const CLI::ParseError& error) {
    throw InputError(error.what());
  }
  return globals.exit_code;
}

}  // namespace kappamu::python
