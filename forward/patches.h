// A surface in patches that do not depend on its triangles: what two answers are compared on. A
// patch is what lies in one cell of a lattice over the object's box and faces one of the six axes.
#pragma once

#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward {

/// Of comparisons: patches along the longest edge of an object's box.
inline constexpr int patches_across = 8;

struct Patches {
  std::vector<int> of_sample;  ///< per surface sample, by its position and normal
  std::vector<double> area;    ///< per patch, of its samples [mm²]

  std::size_t size() const { return area.size(); }
  /// Mean over each patch of values per sample.
  std::vector<double> mean(const std::vector<double>& samples, const Surface& surface) const;
  /// Standard error of that mean for samples of these errors. Of a random walk that leaves once,
  /// errors of samples are negatively correlated by their share of the light: it is slightly too
  /// large. Samples of value 0 count for nothing.
  std::vector<double> error_of_mean(const std::vector<double>& samples,
                                    const std::vector<double>& standard_error,
                                    const Surface& surface) const;
};

/// `cells` along the box's longest edge.
Patches make_patches(const Surface& surface, const Eigen::AlignedBox3d& box, int cells);

}  // namespace kappamu::forward
