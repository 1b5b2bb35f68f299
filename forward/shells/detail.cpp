#include "forward/shells/detail.h"

#include <algorithm>
#include <cmath>

namespace kappamu::forward::shells {

using Eigen::Array4d;
using Eigen::Vector3d;

ShellDetail ShellDetail::of(int layers, double height_px, double apart_px) {
  ShellDetail detail{layers, 0.0};
  const double wanted = std::max(height_px / apart_px, 1e-3);
  const auto halves = [&] { return detail.count > 4 && detail.count % 2 == 0; };
  while (halves() && 0.5 * detail.count >= wanted) detail.count /= 2;
  if (halves() && wanted < detail.count) detail.merged = std::log2(detail.count / wanted);
  return detail;
}

double ShellDetail::level(int layers) const {
  return std::log2(static_cast<double>(layers) / count) + merged;
}

LitLevels lit_levels(const HairTexture& texture, double r, const TexelRadiance& radiance) {
  LitLevels lit;
  lit.optical_height = r * texture.height();
  lit.height = texture.height();
  lit.width = texture.width;
  LitLevels::Level level{texture.width, texture.layers, {}};
  level.texels.resize(texture.size(), Array4d::Zero());
  for (std::size_t i = 0; i < texture.size(); ++i) {
    const double density = texture.density[i];
    if (density <= 0.0) continue;
    level.texels[i].head<3>() = density * radiance(i);
    level.texels[i][3] = density;
  }
  for (;;) {
    lit.levels.push_back(level);
    if (level.width % 2 != 0 || level.layers % 2 != 0) return lit;
    const LitLevels::Level& fine = lit.levels.back();
    level = {fine.width / 2, fine.layers / 2, {}};
    for (int z = 0; z < level.layers; ++z) {
      for (int y = 0; y < level.width; ++y) {
        for (int x = 0; x < level.width; ++x) {
          Array4d sum = Array4d::Zero();
          for (int k = 0; k < 8; ++k) {
            sum += fine.texels[static_cast<std::size_t>(
                ((2 * z + k / 4) * fine.width + 2 * y + k / 2 % 2) * fine.width + 2 * x + k % 2)];
          }
          level.texels.push_back(sum / 8.0);
        }
      }
    }
  }
}

namespace {

/// Place in [0, 1)² of the tile, which repeats, and 0 to 1 in height.
Array4d looked_up(const LitLevels::Level& level, const Vector3d& place) {
  const auto wrapped = [&](int i) { return ((i % level.width) + level.width) % level.width; };
  const Vector3d at(place.x() * level.width - 0.5, place.y() * level.width - 0.5,
                    std::clamp(place.z() * level.layers - 0.5, 0.0, level.layers - 1.0));
  const Vector3d low(std::floor(at.x()), std::floor(at.y()), std::floor(at.z()));
  const Vector3d share = at - low;
  Array4d sum = Array4d::Zero();
  for (int k = 0; k < 8; ++k) {
    const int dx = k % 2, dy = k / 2 % 2, dz = k / 4;
    const double weight = (dx != 0 ? share.x() : 1.0 - share.x()) *
                          (dy != 0 ? share.y() : 1.0 - share.y()) *
                          (dz != 0 ? share.z() : 1.0 - share.z());
    if (weight <= 0.0) continue;
    const int z = std::min(static_cast<int>(low.z()) + dz, level.layers - 1);
    sum += weight * level.texels[static_cast<std::size_t>(
                        (z * level.width + wrapped(static_cast<int>(low.y()) + dy)) * level.width +
                        wrapped(static_cast<int>(low.x()) + dx))];
  }
  return sum;
}

}  // namespace

SeenHair seen_by_detail(const LitLevels& lit, const ShellDetail& detail, const Vector3d& origin,
                        const Vector3d& direction) {
  const double last = static_cast<double>(lit.levels.size() - 1);
  const double level = std::clamp(detail.level(lit.levels[0].layers), 0.0, last);
  const auto fine = static_cast<std::size_t>(level);
  const std::size_t coarse = std::min(fine + 1, lit.levels.size() - 1);
  const double share = level - static_cast<double>(fine);
  SeenHair seen;
  for (int i = detail.count - 1; i >= 0 && seen.transmittance > 1e-3; --i) {
    const double weight = detail.weight(i);
    if (weight <= 0.0) continue;
    const double height = detail.height(i);
    const double way = (height * lit.height - origin.z()) / direction.z();
    if (way < 0.0) continue;
    const Vector3d point = origin + way * direction;
    const Vector3d place(point.x() / lit.width, point.y() / lit.width, height);
    Array4d met = looked_up(lit.levels[fine], place);
    if (share > 0.0) met += share * (looked_up(lit.levels[coarse], place) - met);
    if (met[3] <= 0.0) continue;
    const double alpha = -std::expm1(-weight * met[3] * lit.optical_height / detail.count /
                                     std::max(-direction.z(), 1e-3));
    seen.radiance += seen.transmittance * alpha / met[3] * met.head<3>();
    seen.transmittance *= 1.0 - alpha;
  }
  return seen;
}

}  // namespace kappamu::forward::shells
