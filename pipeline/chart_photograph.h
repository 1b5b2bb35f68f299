// A colour chart measured in one photograph, without a session: what `kappamu chart` does.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "capture/session/session.h"

namespace kappamu::pipeline {

struct ChartPatchMeans {
  std::string name;  ///< "dark skin" ... "black", the ColorChecker Classic's
  std::array<double, 2> centre_px{};
  std::array<double, 3> mean{};       ///< R, G, B code over the patch's middle half
  std::array<double, 3> deviation{};  ///< standard deviation of the codes there
  int pixels = 0;
  int saturated = 0;  ///< of them, in any channel
};

struct ChartPhotograph {
  std::array<ChartPatchMeans, 24> patches;
  int outlines = 24;  ///< patches whose own outline was seen; 24 where corners were given
  /// [channel] slope of ln code over ln reflectance of the unsaturated neutrals: 1 where codes are
  /// proportional to light, about 0.45 behind a display's curve.
  std::array<double, 3> neutral_slope{};
};

/// Centres [px] of the dark skin, bluish green, black and white patches.
using ChartCorners = std::array<std::array<double, 2>, 4>;

/// Finds the ColorChecker Classic in the photograph, or takes the given corners, and writes
/// output/chart.csv (a line per patch) and output/chart.png (the picture with the measured
/// quadrilaterals). Throws InputError naming the photograph if it has not three channels, shows no
/// chart, or the corners leave it.
ChartPhotograph measure_chart_photograph(const std::filesystem::path& photograph,
                                         capture::Encoding encoding,
                                         const std::optional<ChartCorners>& corners,
                                         const std::filesystem::path& output);

}  // namespace kappamu::pipeline
