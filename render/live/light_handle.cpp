#include "render/live/light_handle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180.0;

/// Of a light that stands somewhere; none: it does not.
PointLight* point_of(Light& light) {
  if (auto* point = std::get_if<PointLight>(&light)) return point;
  if (auto* spot = std::get_if<SpotLight>(&light)) return &spot->point;
  if (auto* projector = std::get_if<ProjectorLight>(&light)) return &projector->point;
  return nullptr;
}

const PointLight* point_of(const Light& light) {
  return point_of(const_cast<Light&>(light));
}

Vector3d direction_at(const LightAngles& angles) {
  const double azimuth = angles.azimuth_deg * degree, elevation = angles.elevation_deg * degree;
  return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
          std::cos(azimuth) * std::cos(elevation)};
}

void require_angles(const Light& light) {
  if (!has_angles(light)) throw InputError("light from everywhere has no place to turn about");
}

}  // namespace

std::string kind_of(const Light& light) {
  constexpr std::array<const char*, 5> names{"directional", "point", "spot", "projector",
                                             "environment"};
  return names[light.index()];
}

bool has_angles(const Light& light) {
  return !std::holds_alternative<EnvironmentLight>(light);
}

LightAngles angles_of(const Light& light, const Vector3d& centre) {
  require_angles(light);
  const Vector3d to = towards(light, centre);
  return {std::atan2(to.x(), to.z()) / degree, std::asin(std::clamp(to.y(), -1.0, 1.0)) / degree};
}

Light turned_to(Light light, const Vector3d& centre, const LightAngles& angles) {
  require_angles(light);
  return turned_towards(std::move(light), centre, direction_at(angles));
}

Vector3d towards(const Light& light, const Vector3d& centre) {
  if (const PointLight* point = point_of(light)) {
    const Vector3d arm = point->position_mm - centre;
    return arm.norm() > 0.0 ? Vector3d(arm.normalized()) : Vector3d::UnitY();
  }
  if (const auto* directional = std::get_if<DirectionalLight>(&light)) {
    return -directional->direction.normalized();
  }
  return direction_at({std::get<EnvironmentLight>(light).turn_deg, 0.0});
}

Light turned_towards(Light light, const Vector3d& centre, const Vector3d& direction) {
  if (PointLight* point = point_of(light)) {
    point->position_mm = centre + (point->position_mm - centre).norm() * direction.normalized();
  } else if (auto* directional = std::get_if<DirectionalLight>(&light)) {
    directional->direction = -direction.normalized();
  } else {
    std::get<EnvironmentLight>(light).turn_deg = std::atan2(direction.x(), direction.z()) / degree;
  }
  return light;
}

std::optional<double> distance_of(const Light& light, const Vector3d& centre) {
  const PointLight* point = point_of(light);
  if (point == nullptr) return std::nullopt;
  return (point->position_mm - centre).norm();
}

Light at_distance(Light light, const Vector3d& centre, double distance_mm) {
  if (PointLight* point = point_of(light)) {
    point->position_mm = centre + distance_mm * towards(light, centre);
  }
  return light;
}

const Colour& intensity_of(const Light& light) {
  if (const PointLight* point = point_of(light)) return point->irradiance;
  if (const auto* directional = std::get_if<DirectionalLight>(&light)) {
    return directional->irradiance;
  }
  return std::get<EnvironmentLight>(light).radiance;
}

Colour& intensity_of(Light& light) {
  return const_cast<Colour&>(intensity_of(std::as_const(light)));
}

}  // namespace kappamu::render
