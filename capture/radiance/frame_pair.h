// Gain and shift between two frames of a stack, from means over blocks of 4 x 4 pixels.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "capture/response/noise_model.h"

namespace kappamu::capture {

inline constexpr int block_px = 4;
inline constexpr double block_pixels = block_px * block_px;
/// Blocks fainter than this many of their standard deviations in the shorter frame say little of
/// gain.
inline constexpr double least_signal_to_noise = 5.0;

/// Mean linear signal of the blocks of one frame; not a number where a pixel is saturated or lies
/// outside the frame.
struct Blocks {
  int columns = 0;
  int rows = 0;
  double exposure_s = 0.0;
  std::vector<float> signal;

  float at(int column, int row) const {
    return signal[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(column)];
  }
};

/// How the longer exposed frame of a pair differs from the shorter one.
struct FramePair {
  double log_gain = 0.0;  // of the longer frame relative to the shorter
  double gain_variance = 0.0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  // [px], likewise
  double shift_variance = 0.0;
};

/// Compares the frames where both have signal: the longer one's time is stretched by the gain, its
/// blocks are moved by the shift in whole pixels, which stands where it lowers the misfit of the
/// blocks that both places see. `longer_at` gives its blocks with their grid moved by so many
/// pixels. The variances are those of the noise model, or of the scatter between 8 x 8 parts of the
/// picture where that is larger. Nothing where fewer than 30 blocks have signal in both.
std::optional<FramePair> compare_pair(
    const Blocks& shorter, const std::function<Blocks(const Eigen::Vector2i&)>& longer_at,
    const NoiseModel& noise);

/// Whether `frame` is black where `lit`, of the same scene, promises light far above its noise:
/// less than a tenth of that light in nine of ten blocks, of 30 at least.
bool is_blank(const Blocks& frame, const Blocks& lit, const NoiseModel& noise);

}  // namespace kappamu::capture
