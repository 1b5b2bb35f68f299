#include "app/light_options.h"

#include <CLI/CLI.hpp>

namespace kappamu::app {

void add_fit_light(CLI::App& command, capture::FitLight& light) {
  using capture::FitLight;
  using capture::LightShape;
  constexpr int most = 100;  // of a projector's pixels hardly more are distinguished
  const auto choice = [&](const char* name, LightShape shape, const char* text) {
    const auto choose = [&light, shape](int n) { light = FitLight{shape, n}; };
    return command.add_option_function<int>(name, choose, text)
        ->type_name("N")
        ->check(CLI::Range(1, most));
  };
  auto* const bars = choice("--bars", LightShape::bars,
                            "Fit patterns: N bars across either axis of the lit face, 2 N in all "
                            "[8; docs/benchmarks.md, \"Which light\"]");
  choice("--patches", LightShape::patches, "Fit patterns: N x N patches of the lit face instead")
      ->excludes(bars);
}

}  // namespace kappamu::app
