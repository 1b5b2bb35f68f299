// Variance of one frame's linear signal: photon shot noise, read noise, rounding to codes.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "capture/radiometry.h"

namespace kappamu::capture {

/// Tabulated over the signal x (fraction of full scale): x/N + (r/N)² + (dx/dcode)²/12, with N
/// electrons_full_scale and r read_noise_electrons. The last term is left out for float frames.
class NoiseModel {
 public:
  NoiseModel(const std::vector<double>& response, const Noise& noise, bool with_rounding);

  /// Variance of the signal where its expected value is x; x < 0 counts as 0, x > 1 as 1.
  float variance(float x) const {
    // Written so that x < 0 gives index 0 without a branch on noisy data.
    const float root = std::sqrt(x > 0.0F ? x : 0.0F);
    const float at = 0.5F + (root < 1.0F ? root : 1.0F) * (entries - 1);
    return table_[static_cast<std::size_t>(at)];
  }

 private:
  // Entries are even in √x, where the sum is nearly straight; the nearest one is within 0.1 %
  // wherever shot noise rules.
  static constexpr int entries = 4096;
  std::vector<float> table_;
};

}  // namespace kappamu::capture
