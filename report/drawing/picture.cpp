#include "report/drawing/picture.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "io/image/image_file.h"

namespace kappamu::report {

namespace {

using Colour = std::array<std::uint8_t, 3>;

constexpr std::array<Colour, 9> viridis{{{68, 1, 84},
                                         {71, 44, 122},
                                         {59, 81, 139},
                                         {44, 113, 142},
                                         {33, 144, 141},
                                         {39, 173, 129},
                                         {92, 200, 99},
                                         {170, 220, 50},
                                         {253, 231, 37}}};

constexpr std::array<Colour, 11> red_blue{{{5, 48, 97},
                                           {33, 102, 172},
                                           {67, 147, 195},
                                           {146, 197, 222},
                                           {209, 229, 240},
                                           {247, 247, 247},
                                           {253, 219, 199},
                                           {244, 165, 130},
                                           {214, 96, 77},
                                           {178, 24, 43},
                                           {103, 0, 31}}};

Colour interpolated(std::span<const Colour> anchors, double position) {
  const double at = std::clamp(position, 0.0, 1.0) * static_cast<double>(anchors.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), anchors.size() - 2);
  const double share = at - static_cast<double>(below);
  Colour result{};
  for (std::size_t c = 0; c < 3; ++c)
    result[c] = static_cast<std::uint8_t>(
        std::lround((1.0 - share) * anchors[below][c] + share * anchors[below + 1][c]));
  return result;
}

constexpr Colour unknown_grey{190, 190, 190};

/// The transfer curve of sRGB (IEC 61966-2-1).
double srgb_encoded(double linear) {
  const double value = std::clamp(linear, 0.0, 1.0);
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string result;
  result.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = (group << 8) | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      result += k <= count ? digits[(group >> (18 - 6 * k)) & 63U] : '=';
  }
  return result;
}

}  // namespace

std::array<std::uint8_t, 3> colour_of(ColourMap map, double position) {
  return map == ColourMap::viridis ? interpolated(viridis, position)
                                   : interpolated(red_blue, position);
}

Image<std::uint8_t> coloured(const Image<float>& values, ColourMap map, double low, double high) {
  Image<std::uint8_t> result(values.width(), values.height(), 3);
  const double span = high > low ? high - low : 1.0;
  for (int y = 0; y < values.height(); ++y)
    for (int x = 0; x < values.width(); ++x) {
      const double value = values(x, y);
      const Colour colour =
          std::isfinite(value) ? colour_of(map, (value - low) / span) : unknown_grey;
      for (int c = 0; c < 3; ++c) result(x, y, c) = colour[static_cast<std::size_t>(c)];
    }
  return result;
}

Image<std::uint8_t> tone_mapped(const Image<float>& linear, double white) {
  const int channels = linear.channels() == 3 ? 3 : 1;
  Image<std::uint8_t> result(linear.width(), linear.height(), channels);
  const double scale = white > 0.0 ? 1.0 / white : 1.0;
  for (int y = 0; y < linear.height(); ++y)
    for (int x = 0; x < linear.width(); ++x)
      for (int c = 0; c < channels; ++c) {
        const double value = linear(x, y, c);
        result(x, y, c) = static_cast<std::uint8_t>(
            std::isfinite(value) ? std::lround(255.0 * srgb_encoded(scale * value)) : 0);
      }
  return result;
}

Image<float> reduced(const Image<float>& image, int longest) {
  const int factor = (std::max(image.width(), image.height()) + longest - 1) / longest;
  if (factor <= 1) return image;
  Image<float> result((image.width() + factor - 1) / factor, (image.height() + factor - 1) / factor,
                      image.channels());
  for (int y = 0; y < result.height(); ++y)
    for (int x = 0; x < result.width(); ++x)
      for (int c = 0; c < image.channels(); ++c) {
        double sum = 0.0;
        int count = 0;
        for (int v = y * factor; v < std::min((y + 1) * factor, image.height()); ++v)
          for (int u = x * factor; u < std::min((x + 1) * factor, image.width()); ++u) {
            if (!std::isfinite(image(u, v, c))) continue;
            sum += image(u, v, c);
            ++count;
          }
        result(x, y, c) = count > 0 ? static_cast<float>(sum / count) : std::nanf("");
      }
  return result;
}

double quantile(std::vector<float> values, double fraction) {
  std::erase_if(values, [](float value) { return !std::isfinite(value); });
  if (values.empty()) return 0.0;
  const auto rank = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

Html picture(const Image<std::uint8_t>& image, int width, const std::string& description) {
  return empty_element("img", {{"src", "data:image/png;base64," + base64(io::encode_png(image))},
                               {"width", std::to_string(width)},
                               {"alt", description}});
}

Html legend(ColourMap map, double low, double high, const std::string& unit, int width) {
  Image<float> ramp(128, 1, 1);
  for (int x = 0; x < ramp.width(); ++x) ramp(x, 0) = static_cast<float>(x) / 127.0F;
  const Html bar = empty_element(
      "img", {{"src", "data:image/png;base64," + base64(io::encode_png(coloured(ramp, map, 0, 1)))},
              {"width", std::to_string(width)},
              {"height", "12"},
              {"class", "bar"},
              {"alt", "colour scale"}});
  Html marks;
  for (const double value : {low, 0.5 * (low + high), high})
    marks += element("span", text(number(value, 3)));
  return element("div", {{"class", "legend"}, {"style", "width:" + std::to_string(width) + "px"}},
                 bar + element("div", {{"class", "marks"}}, marks) +
                     element("div", {{"class", "unit"}}, text(unit)));
}

Html figure(const Html& content, const std::string& caption) {
  return element("figure", content + element("figcaption", text(caption)));
}

}  // namespace kappamu::report
