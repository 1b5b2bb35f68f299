#include "render/live/light_handle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180.0;

/// Where a light stands, if it does.
Vector3d* place_of(Light& light) {
  if (auto* point = std::get_if<PointLight>(&light)) return &point->position_mm;
  if (auto* spot = std::get_if<SpotLight>(&light)) return &spot->point.position_mm;
  if (auto* projector = std::get_if<ProjectorLight>(&light)) return &projector->point.position_mm;
  return nullptr;
}

}  // namespace

bool has_angles(const Light& light) {
  return !std::holds_alternative<EnvironmentLight>(light);
}

LightAngles angles_of(const Light& light, const Vector3d& centre) {
  if (!has_angles(light)) throw InputError("light from everywhere has no place to turn about");
  Light copy = light;
  const Vector3d* place = place_of(copy);
  const Vector3d towards =
      (place != nullptr ? Vector3d(*place - centre)
                        : Vector3d(-std::get<DirectionalLight>(copy).direction))
          .normalized();
  return {std::atan2(towards.x(), towards.z()) / degree,
          std::asin(std::clamp(towards.y(), -1.0, 1.0)) / degree};
}

Light turned_to(Light light, const Vector3d& centre, const LightAngles& angles) {
  if (!has_angles(light)) throw InputError("light from everywhere has no place to turn about");
  const double azimuth = angles.azimuth_deg * degree, elevation = angles.elevation_deg * degree;
  const Vector3d towards(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                         std::cos(azimuth) * std::cos(elevation));
  if (Vector3d* place = place_of(light)) {
    *place = centre + (*place - centre).norm() * towards;
  } else {
    std::get<DirectionalLight>(light).direction = -towards;
  }
  return light;
}

}  // namespace kappamu::render
