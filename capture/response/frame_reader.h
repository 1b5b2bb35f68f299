// One channel of a frame's stored values to linear signal above black, as a fraction of full scale.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "capture/response/noise_model.h"
#include "capture/response/radiometry.h"
#include "capture/response/response.h"

namespace kappamu::capture {

/// Code values through the inverse response.
class CodeReader {
 public:
  static constexpr Rounding rounding = Rounding::to_codes;

  CodeReader(const Radiometry& radiometry, int channel)
      : linear_(radiometry.response.linear[static_cast<std::size_t>(channel)].begin(),
                radiometry.response.linear[static_cast<std::size_t>(channel)].end()),
        saturated_from_(static_cast<std::uint16_t>(
            saturation_code(radiometry.response.linear[static_cast<std::size_t>(channel)]))) {}

  float linear(std::uint16_t code) const { return linear_[code]; }
  bool saturated(std::uint16_t code) const { return code >= saturated_from_; }
  float saturation() const { return linear_[saturated_from_]; }

 private:
  std::vector<float> linear_;
  std::uint16_t saturated_from_;
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

 private:
  float black_;
};

template <class Value>
using FrameReader = std::conditional_t<std::is_same_v<Value, float>, FloatReader, CodeReader>;

}  // namespace kappamu::capture
