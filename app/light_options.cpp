#include "app/light_options.h"

#include <CLI/CLI.hpp>

namespace kappamu::app {

void add_fit_light(CLI::App& command, capture::FitLight& light) {
  using capture::FitLight;
  using capture::LightShape;
  constexpr int most = 100;  // of a projector's pixels few more are distinguished
  const auto choice = [&](const char* name, LightShape shape, const char* text) {
    const auto choose = [&light, shape](int n) {
      light.shape = shape;
      light.n = n;
    };
    return command.add_option_function<int>(name, choose, text)
        ->type_name("N")
        ->check(CLI::Range(1, most));
  };
  auto* const bars = choice("--bars", LightShape::bars,
                            "Fit patterns: N bars across either axis of the lit face, 2 N in all "
                            "[8; docs/benchmarks.md, \"Which light\"]");
  auto* const patches = choice("--patches", LightShape::patches,
                               "Fit patterns: N x N patches of the lit face instead")
                            ->excludes(bars);
  const auto wave = [&light](const std::vector<double>& per_mm) {
    light.shape = LightShape::sinusoids;
    light.sinusoids.per_mm = per_mm;
  };
  auto* const sinusoids =
      command
          .add_option_function<std::vector<double>>(
              "--sinusoids", wave,
              "Fit patterns: sinusoids of these spatial frequencies on the lit face [1/mm], for "
              "`kappamu map`")
          ->type_name("F ...")
          ->excludes(bars)
          ->excludes(patches);
  command
      .add_option("--directions", light.sinusoids.directions_degrees,
                  "In which the sinusoids change, from the lit face's u towards v [degrees]")
      ->type_name("D ...")
      ->capture_default_str()
      ->needs(sinusoids);
  command.add_option("--phases", light.sinusoids.phases, "Of each sinusoid, evenly over a period")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(3, 36))
      ->needs(sinusoids);
}

}  // namespace kappamu::app
