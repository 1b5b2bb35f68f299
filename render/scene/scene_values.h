// Values of a scene's file that its parts share.
#pragma once

#include "io/json_node.h"
#include "render/deform/deformation.h"

namespace kappamu::render {

inline constexpr double largest_mm = 1e6;
inline constexpr double smallest_mm = 1e-6;

inline Eigen::Vector3d vector_of(const io::JsonNode& node, double bound) {
  const std::vector<io::JsonNode> xyz = node.exactly(3);
  return {xyz[0].number_between(-bound, bound), xyz[1].number_between(-bound, bound),
          xyz[2].number_between(-bound, bound)};
}

inline Eigen::Vector3d point_of(const io::JsonNode& node) {
  return vector_of(node, largest_mm);
}

inline Eigen::Vector3d direction_of(const io::JsonNode& node) {
  const Eigen::Vector3d direction = vector_of(node, largest_mm);
  if (direction.norm() < 1e-9) node.fail("has no length; write a direction");
  return direction.normalized();
}

inline double length_of(const io::JsonNode& node) {
  return node.number_between(smallest_mm, largest_mm);
}

/// The list "deform" of an object.
std::vector<Deformation> read_deformations(const io::JsonNode& node);

}  // namespace kappamu::render
