#include "pipeline/chart_photograph.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "calib/targets/chart.h"
#include "capture/import/photograph_session.h"
#include "capture/radiance/chart_search.h"
#include "capture/session/frames.h"
#include "core/error.h"
#include "io/atomic_file.h"
#include "io/image/image_file.h"

namespace kappamu::pipeline {
namespace {

using Codes = Image<std::uint16_t>;

constexpr std::array<const char*, 24> patch_names{
    "dark skin", "light skin",    "blue sky",     "foliage",   "blue flower",  "bluish green",
    "orange",    "purplish blue", "moderate red", "purple",    "yellow green", "orange yellow",
    "blue",      "green",         "red",          "yellow",    "magenta",      "cyan",
    "white",     "neutral 8",     "neutral 6.5",  "neutral 5", "neutral 3.5",  "black"};

calib::ChartPatches patches_of(const ChartCorners& corners) {
  std::array<Eigen::Vector2d, 4> px;
  for (std::size_t i = 0; i < 4; ++i) px[i] = {corners[i][0], corners[i][1]};
  return calib::chart_from_corners(px);
}

ChartPatchMeans mean_of(const Codes& codes, const std::array<Eigen::Vector2d, 4>& middle,
                        int saturated_from) {
  ChartPatchMeans patch;
  std::array<double, 3> squares{};
  for (const auto [x, y] : calib::pixels_inside(middle, codes.width(), codes.height())) {
    ++patch.pixels;
    bool saturated = false;
    for (int c = 0; c < 3; ++c) {
      const double code = codes(x, y, c);
      saturated |= code >= saturated_from;
      patch.mean[static_cast<std::size_t>(c)] += code;
      squares[static_cast<std::size_t>(c)] += code * code;
    }
    patch.saturated += saturated ? 1 : 0;
  }
  for (std::size_t c = 0; c < 3 && patch.pixels > 0; ++c) {
    patch.mean[c] /= patch.pixels;
    patch.deviation[c] =
        std::sqrt(std::max(squares[c] / patch.pixels - patch.mean[c] * patch.mean[c], 0.0));
  }
  return patch;
}

/// Least squares over the neutrals that hold light and are not saturated; 0 for fewer than two.
double slope_of_neutrals(const ChartPhotograph& chart, std::size_t channel) {
  const std::array<double, 6> reflectance = calib::neutral_reflectances();
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < reflectance.size(); ++i) {
    const ChartPatchMeans& patch = chart.patches[18 + i];
    if (patch.saturated > 0 || patch.mean[channel] <= 0.0) continue;
    const double at = std::log(reflectance[i]);
    const double value = std::log(patch.mean[channel]);
    n += 1.0;
    x += at;
    y += value;
    xx += at * at;
    xy += at * value;
  }
  return n < 2.0 ? 0.0 : (n * xy - x * y) / (n * xx - x * x);
}

void draw_line(Image<std::uint8_t>& picture, const Eigen::Vector2d& from,
               const Eigen::Vector2d& to) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).cwiseAbs().maxCoeff())));
  for (int step = 0; step <= steps; ++step) {
    const Eigen::Vector2d at = from + (to - from) * (static_cast<double>(step) / steps);
    const int x = static_cast<int>(std::lround(at.x()));
    const int y = static_cast<int>(std::lround(at.y()));
    if (x < 0 || y < 0 || x >= picture.width() || y >= picture.height()) continue;
    constexpr std::array<std::uint8_t, 3> magenta{255, 0, 255};
    for (int c = 0; c < 3; ++c) picture(x, y, c) = magenta[static_cast<std::size_t>(c)];
  }
}

Image<std::uint8_t> picture_of(const Codes& codes, int top, capture::Encoding encoding,
                               const calib::ChartPatches& patches) {
  const double exponent = encoding == capture::Encoding::linear ? 1.0 / 2.2 : 1.0;
  Image<std::uint8_t> picture(codes.width(), codes.height(), 3);
  std::transform(codes.values().begin(), codes.values().end(), picture.values().begin(),
                 [&](std::uint16_t code) {
                   const double share = std::min(1.0, static_cast<double>(code) / top);
                   return static_cast<std::uint8_t>(std::lround(255.0 * std::pow(share, exponent)));
                 });
  for (const auto& middle : patches.middles) {
    for (std::size_t k = 0; k < 4; ++k) draw_line(picture, middle[k], middle[(k + 1) % 4]);
  }
  return picture;
}

std::string csv(const ChartPhotograph& chart) {
  std::string text = "patch,name,x_px,y_px,R,G,B,std_R,std_G,std_B,pixels,saturated\n";
  for (std::size_t i = 0; i < chart.patches.size(); ++i) {
    const ChartPatchMeans& patch = chart.patches[i];
    char line[256];
    std::snprintf(line, sizeof line, "%zu,%s,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%d,%d\n",
                  i + 1, patch.name.c_str(), patch.centre_px[0], patch.centre_px[1], patch.mean[0],
                  patch.mean[1], patch.mean[2], patch.deviation[0], patch.deviation[1],
                  patch.deviation[2], patch.pixels, patch.saturated);
    text += line;
  }
  return text;
}

}  // namespace

ChartPhotograph measure_chart_photograph(const std::filesystem::path& photograph,
                                         capture::Encoding encoding,
                                         const std::optional<ChartCorners>& corners,
                                         const std::filesystem::path& output) {
  const capture::Session session = capture::photograph_session(photograph, encoding);
  if (session.channels.size() != 3) {
    throw InputError(photograph.string() +
                     ": has one channel; a colour chart is measured in a colour photograph.");
  }
  const Codes codes = capture::load_frame(session, session.patterns.front().frames.front());
  const int top = session.camera.white_level.value_or(capture::largest_code(session.camera));
  ChartPhotograph chart;
  ChartCorners place{};
  if (corners) {
    place = *corners;
  } else {
    const auto found = capture::find_chart_place(codes, session.camera.encoding);
    if (!found) {
      throw InputError(
          photograph.string() +
              ": shows no ColorChecker Classic that can be recognised; fill more of the "
              "picture with it, or give the centres of four patches",
          {{"corners"}});
    }
    place = found->corners_px;
    chart.outlines = found->patches;
  }
  const calib::ChartPatches patches = patches_of(place);
  for (std::size_t i = 0; i < chart.patches.size(); ++i) {
    chart.patches[i] = mean_of(codes, patches.middles[i], static_cast<int>(std::ceil(0.99 * top)));
    chart.patches[i].name = patch_names[i];
    chart.patches[i].centre_px = {patches.centres[i].x(), patches.centres[i].y()};
    if (chart.patches[i].pixels == 0) {
      throw InputError(
          photograph.string() + ": the patch '" + patch_names[i] +
          "' has no pixel in the picture by these corners; give the centres of the dark "
          "skin, bluish green, black and white patches.");
    }
  }
  for (std::size_t c = 0; c < 3; ++c) chart.neutral_slope[c] = slope_of_neutrals(chart, c);
  io::write_text_atomically(output / "chart.csv", csv(chart));
  io::write_image(output / "chart.png", picture_of(codes, top, session.camera.encoding, patches));
  return chart;
}

}  // namespace kappamu::pipeline
