// Variance of one frame's linear signal: photon shot noise, read noise, rounding to codes.
#pragma once

#include <array>
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
    float found = 0.0F;
    variances(&x, 1.0F, 1, &found);
    return found;
  }

  /// variance(factor * x[i]) for `count` values, at most most_at_once. In loops without a branch on
  /// noisy data, which fill wide registers.
  [[gnu::always_inline]] inline void variances(const float* x, float factor, std::size_t count,
                                               float* found) const {
    std::array<std::int32_t, most_at_once> at;
    for (std::size_t i = 0; i < count; ++i) {
      const float signal = factor * x[i];
      const float root = std::sqrt(signal > 0.0F ? signal : 0.0F);
      at[i] = static_cast<std::int32_t>(0.5F + (root < 1.0F ? root : 1.0F) * (entries - 1));
    }
    for (std::size_t i = 0; i < count; ++i) found[i] = table_[static_cast<std::size_t>(at[i])];
    for (std::size_t i = 0; i < count; ++i) {
      const float signal = factor * x[i];
      const float below = (signal < 0.0F ? signal : 0.0F) * shot_per_signal_;
      const float sum = found[i] + below;
      found[i] = sum > least_ ? sum : least_;
    }
  }
  static constexpr std::size_t most_at_once = 256;

 private:
  // Entries are even in √x, where the sum is nearly straight; the nearest one is within 0.1 %
  // wherever shot noise rules.
  static constexpr int entries = 4096;
  std::vector<float> table_;
  float shot_per_signal_ = 0.0F;  // 1/N
  float least_ = 0.0F;
};

}  // namespace kappamu::capture
