// Where a light stands as seen from a point, by two angles that a person can turn.
#pragma once

#include "render/scene/scene.h"

namespace kappamu::render {

struct LightAngles {
  double azimuth_deg = 0.0;    ///< about y, from +z towards +x
  double elevation_deg = 0.0;  ///< above the x z plane
};

/// False for light from everywhere, which has no place.
bool has_angles(const Light& light);

/// Of the light's place about `centre`; of directional light, of where it comes from. Throws
/// InputError for an environment.
LightAngles angles_of(const Light& light, const Eigen::Vector3d& centre);

/// The light carried round `centre` to these angles, at its distance. What it aims at stays.
Light turned_to(Light light, const Eigen::Vector3d& centre, const LightAngles& angles);

}  // namespace kappamu::render
