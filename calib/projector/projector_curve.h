// The projector's response: how its light grows with the value of a pixel, from the white target
// under several values.
#pragma once

#include <array>
#include <optional>
#include <vector>

namespace kappamu::calib {

struct ProjectorCurve {
  std::vector<int> values;  ///< measured ones, rising, 0 first and 255 last
  /// [channel][value] light beyond black's over white's beyond black's: 0 at 0, 1 at 255.
  std::vector<std::vector<double>> light;

  double mean(std::size_t value) const;  ///< over the channels, of values[value]
  /// Largest distance of a channel from the mean, in shares of white.
  double channel_spread() const;
};

/// From the target's signals [value][channel]; the first is black's, the last white's.
ProjectorCurve curve_from_signals(const std::vector<int>& values,
                                  const std::vector<std::vector<double>>& signals);

/// Light of each pixel value beyond black's, in shares of white's.
using LightTable = std::array<float, 256>;

/// The channels' mean, monotone cubic between the measured values (Fritsch & Carlson 1980);
/// proportional to the value where nothing was measured.
LightTable light_table(const std::optional<ProjectorCurve>& curve);

/// value^exponent: 2.2 is what pictures are made for and most projectors follow.
LightTable power_table(double exponent);

}  // namespace kappamu::calib
