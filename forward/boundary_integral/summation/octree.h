// Cubes about the elements that a sum runs over: sources and targets, each at its centre.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

namespace kappamu::forward::boundary_integral {

struct Box {
  std::array<int, 3> at{};  ///< in widths of its level, from the root's corner
  int level = 0;
  std::array<int, 8> child{-1, -1, -1, -1, -1, -1, -1, -1};  ///< x fastest; −1: empty
  int first_source = 0, end_source = 0, first_target = 0, end_target = 0;  ///< in the tree's order

  int sources() const { return end_source - first_source; }
  int targets() const { return end_target - first_target; }
  bool leaf() const {
    for (const int c : child) {
      if (c >= 0) return false;
    }
    return true;
  }
};

struct Octree {
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();  ///< of the root [mm]
  double root_width = 0.0;                           ///< [mm]
  std::vector<Box> boxes;                            ///< parents before children, by level
  std::vector<int> level_begin;                      ///< of each level, and the end
  std::vector<int> source, target;                   ///< elements in the tree's order

  int levels() const { return static_cast<int>(level_begin.size()) - 1; }
  double width(int level) const { return std::ldexp(root_width, -level); }
  Eigen::Vector3d centre(const Box& box) const {
    return corner + width(box.level) *
                        (Eigen::Vector3d(box.at[0], box.at[1], box.at[2]).array() + 0.5).matrix();
  }
};

/// Where an element is, and how far from there its points lie at most [mm].
struct Place {
  Eigen::Vector3d centre;
  double reach = 0.0;
};

/// Of a box's width, how far points may lie outside the box that holds their element's centre.
inline constexpr double box_reach = 0.1;

/// Boxes that hold more than `most` sources or targets are split where all their elements' points
/// stay within reach of the halves.
Octree make_octree(const std::vector<Place>& sources, const std::vector<Place>& targets, int most);

}  // namespace kappamu::forward::boundary_integral
