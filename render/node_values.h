// Values that several parts of a scene have, read from its file.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "io/json_node.h"
#include "render/colour.h"

namespace kappamu::render {

inline constexpr double largest_mm = 1e6;
inline constexpr double smallest_mm = 1e-6;
inline constexpr double largest_light = 1e6;

inline Eigen::Vector3d three_of(const io::JsonNode& node, double smallest, double largest) {
  const std::vector<io::JsonNode> xyz = node.exactly(3);
  return {xyz[0].number_between(smallest, largest), xyz[1].number_between(smallest, largest),
          xyz[2].number_between(smallest, largest)};
}

inline Eigen::Vector3d point_of(const io::JsonNode& node) {
  return three_of(node, -largest_mm, largest_mm);
}

inline Eigen::Vector3d direction_of(const io::JsonNode& node) {
  const Eigen::Vector3d direction = point_of(node);
  if (direction.norm() < 1e-9) node.fail("has no length; write a direction");
  // A direction of unit length stays what it is to the last bit: a recipe replayed is the same.
  return std::abs(direction.norm() - 1.0) < 1e-12 ? direction : direction.normalized();
}

/// One number for all channels, or three.
inline Colour colour_of(const io::JsonNode& node, double largest, double smallest = 0.0) {
  if (node.is_number()) return Colour::Constant(node.number_between(smallest, largest));
  return three_of(node, smallest, largest).array();
}

inline std::string name_of(const io::JsonNode& node) {
  std::string name = node.text();
  if (name.empty()) node.fail("is empty; write a name");
  return name;
}

inline std::filesystem::path path_of(const io::JsonNode& node,
                                     const std::filesystem::path& folder) {
  const std::string name = node.text();
  if (name.empty()) node.fail("is empty; write a file's name");
  return folder / name;
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
