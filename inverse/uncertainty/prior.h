// The regulariser as what is known of a block beforehand.
#pragma once

#include <vector>

namespace kappamu::inverse {

struct Prior {
  double weight = 1.0;            ///< α
  double thickness_mm = 1.0;      ///< ℓ (roughness.h)
  double anchor_length_mm = 1.0;  ///< L
  /// Of Huber-TV at the volume (Roughness::diffusivity), for how the fit yields; empty for H1, and
  /// for deviations, which presume no edge.
  std::vector<double> diffusivity{};
  /// α of each band of waves where log κ varies more than `weight` expects (long_waves.h); empty:
  /// nowhere.
  std::vector<double> wave_weights{};
};

}  // namespace kappamu::inverse
