// Values that several parts of a scene have, read from its file.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "io/json_node.h"
#include "render/colour.h"

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

/// One number for all channels, or three.
inline Colour colour_of(const io::JsonNode& node, double largest, double smallest = 0.0) {
  if (node.is_number()) return Colour::Constant(node.number_between(smallest, largest));
  const std::vector<io::JsonNode> rgb = node.exactly(3);
  return {rgb[0].number_between(smallest, largest), rgb[1].number_between(smallest, largest),
          rgb[2].number_between(smallest, largest)};
}

inline std::string name_of(const io::JsonNode& node) {
  std::string name = node.text();
  if (name.empty()) node.fail("is empty; write a name");
  return name;
}

inline std::filesystem::path path_of(const io::JsonNode& node,
                                     const std::filesystem::path& folder) {
  return folder / name_of(node);
}

inline double length_of(const io::JsonNode& node) {
  return node.number_between(smallest_mm, largest_mm);
}

inline std::variant<double, Eigen::Vector3d> size_of(const io::JsonNode& node) {
  if (node.is_number()) return length_of(node);
  const std::vector<io::JsonNode> xyz = node.exactly(3);
  return Eigen::Vector3d(length_of(xyz[0]), length_of(xyz[1]), length_of(xyz[2]));
}

inline int whole_number(const io::JsonNode& node, int smallest, int largest) {
  node.number_between(smallest, largest);
  return node.integer();
}

}  // namespace kappamu::render
