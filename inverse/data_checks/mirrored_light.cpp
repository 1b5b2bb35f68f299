#include "inverse/data_checks/mirrored_light.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/shown_text.h"

namespace kappamu::inverse {

namespace {

// Pictures of a right and of a mirrored session correlate at 0.99 and −0.99; those of one mirrored
// in part, or of a few patterns in the wrong order, lie between.
constexpr double mirrored_correlation = -0.6;
constexpr int least_patterns = 4;  // beside the middle of all
// Of the face's width. Light of less moves by what it meets, not by where it falls: sinusoids of
// two periods and more.
constexpr double least_move = 0.1;
constexpr double least_common = 0.5;  // of the seen face, used under every pattern

using Centroid = std::array<double, 2>;  // along u, v [cells]

Centroid centroid(const float* map, const FaceShape& face, const std::vector<std::uint8_t>& used) {
  double sum = 0.0;
  Centroid moment{};
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      const auto i = static_cast<std::size_t>(v) * static_cast<std::size_t>(face.nu) +
                     static_cast<std::size_t>(u);
      if (!used.empty() && used[i] == 0) continue;
      sum += map[i];
      moment[0] += map[i] * u;
      moment[1] += map[i] * v;
    }
  }
  return {moment[0] / sum, moment[1] / sum};
}

/// 1 where every pattern of the channel is used; empty if that is too little of the face.
std::vector<std::uint8_t> used_by_all(const SurfaceMeasurements& measured, std::size_t first,
                                      std::size_t cells) {
  std::vector<std::uint8_t> used(cells, 1);
  std::size_t count = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    for (int m = 0; m < measured.patterns && !measured.mask.empty(); ++m) {
      if (measured.mask[first + static_cast<std::size_t>(m) * cells + i] == 0) used[i] = 0;
    }
    count += used[i];
  }
  if (static_cast<double>(count) < least_common * static_cast<double>(cells)) used.clear();
  return used;
}

}  // namespace

std::optional<std::string> mirrored_light(const SurfaceMeasurements& measured, int channel) {
  if (measured.two_faces() || measured.seen_face != opposite(measured.lit_face)) {
    return std::nullopt;
  }
  const FaceShape lit = measured.lit_shape(), seen = measured.seen_shape();
  const std::size_t cells = seen.cells();
  const std::size_t first =
      static_cast<std::size_t>(channel) * static_cast<std::size_t>(measured.patterns) * cells;
  const std::vector<std::uint8_t> used = used_by_all(measured, first, cells);
  if (used.empty()) return std::nullopt;
  std::vector<Centroid> light, picture;
  for (std::size_t m = 0; m < static_cast<std::size_t>(measured.patterns); ++m) {
    const Centroid in = centroid(measured.irradiance.data() + m * lit.cells(), lit, {});
    const Centroid out = centroid(measured.value.data() + first + m * cells, seen, used);
    if (!std::isfinite(in[0] + in[1] + out[0] + out[1])) continue;  // of a dark pattern
    light.push_back(in);
    picture.push_back(out);
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto count = static_cast<double>(light.size());
    double mean_in = 0.0, mean_out = 0.0, in_in = 0.0, out_out = 0.0, in_out = 0.0;
    for (std::size_t m = 0; m < light.size(); ++m) {
      mean_in += light[m][axis] / count;
      mean_out += picture[m][axis] / count;
    }
    const double width = axis == 0 ? lit.nu : lit.nv;
    int elsewhere = 0;
    for (std::size_t m = 0; m < light.size(); ++m) {
      const double in = light[m][axis] - mean_in, out = picture[m][axis] - mean_out;
      in_in += in * in;
      out_out += out * out;
      in_out += in * out;
      elsewhere += std::abs(in) > least_move * width ? 1 : 0;
    }
    if (elsewhere < least_patterns) continue;
    const double correlation = in_out / std::sqrt(in_in * out_out);
    if (!(correlation <= mirrored_correlation)) continue;
    const char along = "xyz"[face_axes(measured.lit_face)[axis]];
    return formatted(
        "From pattern to pattern the seen light moves towards -%c where the light on the lit face "
        "moves towards +%c (correlation %.2f): pictures and light are mirrored to each other. "
        "Switch off mirroring and rear projection in the projector and in what saves the "
        "photographs, or mirror the patterns' images (of measurements, irradiance.npy).",
        along, along, correlation);
  }
  return std::nullopt;
}

}  // namespace kappamu::inverse
