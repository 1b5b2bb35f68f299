// One channel of a frame's stored values to linear signal above black, as a fraction of full scale.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "capture/response/noise_model.h"
#include "capture/response/radiometry.h"
#include "capture/response/response.h"

namespace kappamu::capture {

/// A signal that rises by `scale` with each unit of the stored value.
struct Line {
  float zero = 0.0F;  ///< the value of no signal
  float scale = 1.0F;
};

/// Code values through the inverse response.
class CodeReader {
 public:
  static constexpr Rounding rounding = Rounding::to_codes;

  CodeReader(const Radiometry& radiometry, int channel)
      : linear_(radiometry.response.linear[static_cast<std::size_t>(channel)].begin(),
                radiometry.response.linear[static_cast<std::size_t>(channel)].end()),
        saturated_from_(static_cast<std::uint16_t>(
            saturation_code(radiometry.response.linear[static_cast<std::size_t>(channel)]))),
        line_(line_of(radiometry.response.linear[static_cast<std::size_t>(channel)])) {}

  float linear(std::uint16_t code) const { return linear_[code]; }
  bool saturated(std::uint16_t code) const { return code >= saturated_from_; }
  float saturation() const { return linear_[saturated_from_]; }
  std::uint16_t saturated_from() const { return saturated_from_; }
  const std::vector<float>& table() const { return linear_; }
  /// Of a linear camera, for codes that are not saturated.
  const std::optional<Line>& line() const { return line_; }

 private:
  std::optional<Line> line_of(const std::vector<double>& response) const {
    const double scale = (response[saturated_from_] - response[0]) / saturated_from_;
    constexpr double tolerance = 1e-9;
    for (std::size_t code = 0; code < saturated_from_; ++code) {
      if (std::abs(response[0] + scale * static_cast<double>(code) - response[code]) > tolerance)
        return std::nullopt;
    }
    return Line{static_cast<float>(-response[0] / scale), static_cast<float>(scale)};
  }

  std::vector<float> linear_;
  std::uint16_t saturated_from_;
  std::optional<Line> line_;
};

/// Fractions of full scale (EXR): saturated near 1.
class FloatReader {
 public:
  static constexpr Rounding rounding = Rounding::none;

  FloatReader(const Radiometry& radiometry, int channel)
      : black_(static_cast<float>(radiometry.black_level[static_cast<std::size_t>(channel)] /
                                  ((1 << radiometry.bit_depth) - 1))) {}

  float linear(float value) const { return (value - black_) / (1.0F - black_); }
  bool saturated(float value) const { return value >= saturation(); }
  float saturation() const { return 0.99F; }
  float saturated_from() const { return saturation(); }
  std::span<const float> table() const { return {}; }
  std::optional<Line> line() const { return Line{black_, 1.0F / (1.0F - black_)}; }

 private:
  float black_;
};

template <class Value>
using FrameReader = std::conditional_t<std::is_same_v<Value, float>, FloatReader, CodeReader>;

}  // namespace kappamu::capture
