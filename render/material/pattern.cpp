#include "render/material/pattern.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/numbers/at.h"
#include "core/random.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

/// (Σ g · d), g towards the middle of one of a cube's edges.
double slope(std::uint64_t key, const Vector3d& way) {
  constexpr std::array<std::array<int, 2>, 3> axes{{{0, 1}, {1, 2}, {0, 2}}};
  const std::array<int, 2>& pair = axes[key % 3];
  return ((key >> 8U & 1U) != 0U ? way[pair[0]] : -way[pair[0]]) +
         ((key >> 9U & 1U) != 0U ? way[pair[1]] : -way[pair[1]]);
}

double octaves_of(const Pattern& pattern, const Vector3d& point) {
  double sum = 0.0, strength = 1.0;
  Vector3d position = point / pattern.size_mm;
  for (int i = 0; i < pattern.octaves; ++i) {
    sum +=
        strength * gradient_noise(position, key_of({pattern.seed, static_cast<std::uint64_t>(i)}));
    position *= 2.0;
    strength *= 0.5;
  }
  return sum;
}

}  // namespace

double gradient_noise(const Vector3d& position, std::uint64_t seed) {
  const Vector3d cell = position.array().floor(), rest = position - cell;
  const auto ease = [](double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); };
  const auto key_at = [&](std::uint64_t key, int axis, int step) {
    return key_of({key, static_cast<std::uint64_t>(static_cast<std::int64_t>(cell[axis] + step))});
  };
  std::array<std::array<double, 2>, 3> share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double here = rest[static_cast<Eigen::Index>(axis)];
    share[axis] = {ease(1.0 - here), ease(here)};
  }
  // Corners that share a coordinate share its part of the key.
  std::array<std::uint64_t, 2> of_x{};
  std::array<std::uint64_t, 4> of_xy{};
  for (const int x : {0, 1}) of_x[at(x)] = key_at(seed, 0, x);
  for (int xy = 0; xy < 4; ++xy) of_xy[at(xy)] = key_at(of_x[at(xy & 1)], 1, xy >> 1);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const double weight = share[0][at(x)] * share[1][at(y)] * share[2][at(z)];
    sum += weight * slope(key_at(of_xy[at(corner & 3)], 2, z), rest - Vector3d(x, y, z));
  }
  return std::clamp(sum, -1.0, 1.0);
}

double pattern_at(const Pattern& pattern, const Vector3d& point) {
  const double noise = octaves_of(pattern, point);
  switch (pattern.kind) {
    case Pattern::Kind::marble: {
      const double bands = point.dot(pattern.direction.normalized()) / pattern.size_mm;
      return 0.5 + 0.5 * std::sin(2.0 * std::numbers::pi * (bands + pattern.turbulence * noise));
    }
    case Pattern::Kind::veins:
      return std::exp(-std::pow(noise / pattern.width, 2));
    case Pattern::Kind::noise:
      break;
  }
  return std::clamp(0.5 + noise, 0.0, 1.0);
}

}  // namespace kappamu::render
