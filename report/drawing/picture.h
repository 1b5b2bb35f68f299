// Maps and images as pictures in the page: colour maps, tone mapping, reduction, inline PNG.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"
#include "report/drawing/html.h"

namespace kappamu::report {

enum class ColourMap {
  viridis,   ///< sequential, perceptually even (matplotlib's viridis, sampled at nine points)
  diverging  ///< blue - white - red, even about its middle (ColorBrewer RdBu)
};

/// sRGB colour of `position` in [0, 1]; values outside are clamped.
std::array<std::uint8_t, 3> colour_of(ColourMap map, double position);

/// A scalar map in colours; `low` and `high` take the map's two ends, not-finite values grey.
Image<std::uint8_t> coloured(const Image<float>& values, ColourMap map, double low, double high);

/// Linear light as sRGB, `white` mapped to full white; one channel gives grey, three give colour.
/// Other numbers of channels show their first.
Image<std::uint8_t> tone_mapped(const Image<float>& linear, double white);

/// Box average by the smallest whole factor that brings both sides to at most `longest` pixels.
Image<float> reduced(const Image<float>& image, int longest);

/// The value below which `fraction` of the finite values lie; 0 where there is none.
double quantile(std::vector<float> values, double fraction);

/// <img> with the picture as inline PNG, shown `width` CSS px wide with hard pixel edges.
Html picture(const Image<std::uint8_t>& image, int width, const std::string& description);

/// The colour map as a horizontal bar with `low`, middle and `high` written below, and the unit.
Html legend(ColourMap map, double low, double high, const std::string& unit, int width = 220);

/// A picture with a caption below.
Html figure(const Html& content, const std::string& caption);

}  // namespace kappamu::report
