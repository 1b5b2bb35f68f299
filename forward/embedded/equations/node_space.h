// Continuous trilinear functions on a 2:1 balanced set of cubes: which corner belongs to which
// unknown.
//
// A corner in the middle of a larger neighbour's edge or face hangs: its value is the mean of that
// edge's two or face's four corners, which never hang themselves (2:1 across corners).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "forward/embedded/geometry/octree.h"

namespace kappamu::forward::embedded {

class NodeSpace {
 public:
  NodeSpace() = default;
  /// Unknowns are numbered as the cubes' corners first meet them: Morton cubes, Morton unknowns.
  explicit NodeSpace(const std::vector<Cube>& cubes);

  std::size_t unknowns() const { return unknowns_; }
  std::size_t cubes() const { return corner_.size(); }

  /// The unknowns that make up the value at a cube's corner (x fastest), each with `weight()`.
  std::span<const int> parts(std::size_t cube, std::size_t corner) const {
    const int& code = corner_[cube][corner];
    if (code >= 0) return {&code, 1};
    const auto begin = static_cast<std::size_t>(~code);
    return {masters_.data() + begin + 1, static_cast<std::size_t>(masters_[begin])};
  }
  static double weight(std::span<const int> parts) {
    return 1.0 / static_cast<double>(parts.size());
  }

 private:
  std::size_t unknowns_ = 0;
  std::vector<std::array<int, 8>> corner_;  ///< unknown, or ~(place in masters_) where it hangs
  std::vector<int> masters_;                ///< count, then as many unknowns
};

}  // namespace kappamu::forward::embedded
