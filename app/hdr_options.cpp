#include "app/hdr_options.h"

#include <CLI/CLI.hpp>

#include "pipeline/records/hdr_options.h"

namespace kappamu::app {

namespace {

template <class Value, std::size_t n>
void add_choice(CLI::App& command, const std::string& option, const Names<Value, n>& names,
                Value& value, const std::string& text) {
  std::vector<std::string> allowed;
  for (const auto& [name, unused] : names) allowed.emplace_back(name);
  command
      .add_option_function<std::string>(
          option,
          [&names, &value](const std::string& chosen) { value = value_of(names, chosen).value(); },
          text + " (default " + name_of(names, value) + ")")
      ->check(CLI::IsMember(allowed))
      ->group("Frames to radiance");
}

}  // namespace

void add_hdr_options(CLI::App& command, capture::MergeOptions& options) {
  add_choice(command, "--on-flicker", pipeline::actions, options.on_flicker,
             "A frame brighter or darker than the rest of its stack, or of a mislabelled "
             "exposure: refuse it by name, correct its exposure from the frames, or ignore");
  add_choice(command, "--on-motion", pipeline::motion_actions, options.on_motion,
             "A frame shifted against the rest of its stack, or partly changed: refuse it by "
             "name, correct by leaving it out, align by moving it back, or ignore");
}

}  // namespace kappamu::app
