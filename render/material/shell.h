// What a scene states of a block wrapped round an object.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace kappamu::render {

/// How a block is wrapped round an object (render/material/shell_field.h).
struct Shell {
  enum class Core { synthesised, mean_values };
  enum class Outside { z_plus, z_minus };

  Outside outside = Outside::z_plus;              ///< face of the block that lies on the surface
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();  ///< the block's y, laid along the surface
  double scale = 1.0;                             ///< of the block on the object [dimensionless]
  /// What texture coordinates of 1, 1 are on the block's face [mm]; none: the surface is covered by
  /// pieces of the face without texture coordinates.
  std::optional<Eigen::Vector2d> texture_size_mm;
  Core core = Core::synthesised;  ///< below the block's last layer
  std::uint64_t seed = 1;         ///< of the pieces' places
};

}  // namespace kappamu::render
