#include "app/light_options.h"

#include <CLI/CLI.hpp>

namespace kappamu::app {

void add_fit_light(CLI::App& command, capture::FitLight& light) {
  using capture::LightShape;
  constexpr int most = 100;  // of a projector's pixels hardly more are told apart
  auto* const bars = command
                         .add_option_function<int>(
                             "--bars",
                             [&light](int n) {
                               light = {LightShape::bars, n};
                             },
                             "Fit patterns: N bars across either axis of the lit face, "
                             "2 N in all [8]")
                         ->type_name("N")
                         ->check(CLI::Range(1, most));
  command
      .add_option_function<int>(
          "--patches",
          [&light](int n) {
            light = {LightShape::patches, n};
          },
          "Fit patterns: N x N patches instead; for as many pictures E is "
          "several times larger (docs/benchmarks.md)")
      ->type_name("N")
      ->check(CLI::Range(1, most))
      ->excludes(bars);
}

}  // namespace kappamu::app
