// Variance of one frame's linear signal: photon shot noise, read noise, rounding to codes.
#pragma once

#include <cmath>
#include <cstddef>
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
  /// dark pixels would be too large on average. Written without a branch on noisy data.
  float variance(float x) const {
    const float root = std::sqrt(x > 0.0F ? x : 0.0F);
    const float at = 0.5F + (root < 1.0F ? root : 1.0F) * (entries - 1);
    const float below = x < 0.0F ? x * shot_per_signal_ : 0.0F;
    const float found = table_[static_cast<std::size_t>(at)] + below;
    return found > least_ ? found : least_;
  }

 private:
  // Entries are even in √x, where the sum is nearly straight; the nearest one is within 0.1 %
  // wherever shot noise rules.
  static constexpr int entries = 4096;
  std::vector<float> table_;
  float shot_per_signal_ = 0.0F;  // 1/N
  float least_ = 0.0F;
};

}  // namespace kappamu::capture
