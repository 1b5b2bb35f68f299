// Of a light of a scene that was turned, moved or coloured, what is no longer as the scene has it.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

namespace kappamu::render {

/// What is not stated stays as the scene has it.
struct LightChange {
  std::size_t light = 0;                                ///< in the scene's order, from 0
  std::optional<Eigen::Vector3d> position_mm;           ///< of a point, a spot, a projector
  std::optional<Eigen::Vector3d> direction;             ///< of a directional light
  std::optional<double> turn_deg;                       ///< of an environment
  std::optional<Eigen::Vector3d> irradiance, radiance;  ///< R, G, B; of an environment radiance

  bool empty() const { return !position_mm && !direction && !turn_deg && !irradiance && !radiance; }
};
using LightChanges = std::vector<LightChange>;

/// Its fields, named as the light has them in a scene.
nlohmann::ordered_json fields_of(const LightChange& change);

}  // namespace kappamu::render
