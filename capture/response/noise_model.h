// Variance of one frame's linear signal: photon shot noise, read noise, rounding to codes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "capture/response/radiometry.h"

namespace kappamu::capture {

/// Whether frames hold codes, rounded to whole numbers, or floats.
enum class Rounding { to_codes, none };

/// Tabulated over the signal x (fraction of full scale): x/N + (r/N)² + (dx/dcode)²/12, with N
/// electrons_full_scale and r read_noise_electrons. The last term is left out without rounding.
class NoiseModel {
 public:
  NoiseModel(const std::vector<double>& response, const Noise& noise, Rounding rounding);

  /// Variance of the signal where its expected value is x; x > 1 counts as 1. An estimate x below 0
  /// goes on along x/N, no lower than a quarter of the variance at 0: cut at 0, the variance of
  /// dark pixels would be too large on average.
  float variance(float x) const {
    const float root = std::sqrt(std::clamp(x, 0.0F, 1.0F));
    const auto entry = static_cast<std::size_t>(0.5F + root * (entries - 1));
    const float sum = table_[entry] + std::min(x, 0.0F) * shot_per_signal_;
    return std::max(sum, least_);
  }

  /// Entries are even in √x, where the sum is nearly straight; the nearest one is within 0.1 %
  /// wherever shot noise rules.
  static constexpr int entries = 4096;
  const std::vector<float>& table() const { return table_; }
  float shot_per_signal() const { return shot_per_signal_; }  ///< 1/N
  float least() const { return least_; }                      ///< below any signal
  /// Whether the table's entries are variance(0) + x/N.
  bool straight() const { return straight_; }

 private:
  std::vector<float> table_;
  float shot_per_signal_ = 0.0F;  // 1/N
  float least_ = 0.0F;
  bool straight_ = true;
};

}  // namespace kappamu::capture
