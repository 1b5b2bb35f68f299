#include "app/options/fit_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace kappamu::app {

namespace {

struct AddToCommand {
  CLI::App& command;

  template <class Value>
  void operator()(const Option& option, Value& value) const {
    if (*option.flag == 0) return;
    finish(option, command.add_option(option.flag, value, text(option))->capture_default_str());
  }
  void operator()(const Option& option, std::vector<std::string>& values) const {
    finish(option, command.add_option(option.flag, values, text(option))->type_name("NAME"));
  }
  /// On unless its flag, --no-..., is given.
  void operator()(const Option& option, bool& value) const {
    if (*option.flag == 0) return;
    finish(option, command.add_flag_callback(
                       option.flag, [&value] { value = false; }, "Not: " + text(option)));
  }
  void operator()(const Option& option, std::optional<double>& value) const {
    if (*option.flag == 0) return;
    finish(option, command.add_option_function<double>(
                       option.flag, [&value](double x) { value = x; }, text(option)));
  }
  template <class Value, std::size_t n>
  void operator()(const Option& option, Value& value, const Names<Value, n>& names) const {
    if (*option.flag == 0) return;
    std::vector<std::string> allowed;
    for (const auto& [name, unused] : names) allowed.emplace_back(name);
    auto* added = command.add_option_function<std::string>(
        option.flag,
        [&names, &value](const std::string& name) { value = value_of(names, name).value(); },
        text(option));
    finish(option, added->check(CLI::IsMember(allowed))->default_str(name_of(names, value)));
  }

 private:
  static std::string text(const Option& option) {
    const std::string unit = option.unit;
    return option.text + (unit.empty() ? "" : " [" + unit + "]");
  }
  static void finish(const Option& option, CLI::Option* added) {
    added->group("Fit: " + std::string(option.group));
  }
};

}  // namespace

void add_fit_options(CLI::App& command, pipeline::FitStageOptions& options) {
  pipeline::describe(options, AddToCommand{command});
}

void add_fit_options(CLI::App& command, pipeline::FitStageOptions& options,
                     std::span<const std::string_view> keys) {
  pipeline::describe(options, [&](const Option& option, auto& value, const auto&... names) {
    if (std::find(keys.begin(), keys.end(), option.name) == keys.end()) return;
    AddToCommand{command}(option, value, names...);
  });
}

std::string flag_of(const std::string& key) {
  std::string flag = "--" + key;
  std::replace(flag.begin(), flag.end(), '_', '-');
  const pipeline::FitStageOptions options;
  pipeline::describe(options, [&](const Option& option, const auto&, const auto&...) {
    if (option.name == key && *option.flag != 0) flag = option.flag;
  });
  return flag.substr(0, flag.find(','));
}

void take_globals(const CLI::App& command, const Globals& globals,
                  pipeline::FitStageOptions& options) {
  const CLI::App& program = *command.get_parent();
  inverse::SolverOptions& solver = options.fit.solver;
  if (program.count("--device") > 0) solver.backend.device = globals.device;
  if (program.count("--seed") > 0) solver.seed = globals.seed;
}

}  // namespace kappamu::app
