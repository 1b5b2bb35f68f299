// Where a light stands as seen from a point, by two angles that a person can turn, and how bright
// and coloured it is.
#pragma once

#include <string>

#include "render/scene/scene.h"

namespace kappamu::render {

struct LightAngles {
  double azimuth_deg = 0.0;    ///< about y, from +z towards +x
  double elevation_deg = 0.0;  ///< above the x z plane
};

/// "directional", "point", "spot", "projector" or "environment".
std::string kind_of(const Light& light);

/// False for light from everywhere, which has no place.
bool has_angles(const Light& light);

/// Of the light's place about `centre`; of directional light, of where it comes from. Throws
/// InputError for an environment.
LightAngles angles_of(const Light& light, const Eigen::Vector3d& centre);

/// The light carried round `centre` to these angles, at its distance. What it aims at stays.
Light turned_to(Light light, const Eigen::Vector3d& centre, const LightAngles& angles);

/// Unit vector from `centre` to the light, upwards of one that stands there; of an environment, the
/// direction about y that its turn carries +z to.
Eigen::Vector3d towards(const Light& light, const Eigen::Vector3d& centre);
/// The light turned so that it lies that way; an environment turns about y alone.
Light turned_towards(Light light, const Eigen::Vector3d& centre, const Eigen::Vector3d& direction);

/// Distance of a light that has a place [mm]; none: it has no place.
std::optional<double> distance_of(const Light& light, const Eigen::Vector3d& centre);
/// The light at another distance along the same line, as bright as it is where it is stated to be.
Light at_distance(Light light, const Eigen::Vector3d& centre, double distance_mm);

/// Irradiance, or an environment's radiance, as the scene states it.
const Colour& intensity_of(const Light& light);
Colour& intensity_of(Light& light);

}  // namespace kappamu::render
