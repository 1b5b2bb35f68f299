// A box as an object: the cubic voxels that fill it, and what its triangles have of its faces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/grid.h"
#include "core/mesh/triangle_mesh.h"
#include "core/object_medium.h"

namespace kappamu::forward::block {

struct BlockGrid {
  GridShape shape;
  Eigen::Vector3d corner =
      Eigen::Vector3d::Zero();  ///< smallest x, y, z, in the object's frame [mm]

  BlockGrid refined(int factor) const { return {shape.refined(factor), corner}; }
};

/// The medium's own voxels, or where it is homogeneous 32 or more along the longest edge. None
/// unless the mesh is a box along the axes and its edges whole numbers of such voxels.
std::optional<BlockGrid> block_grid(const TriangleMesh& mesh, const ObjectMedium& medium);
/// Throws InputError where there is none.
BlockGrid require_block_grid(const TriangleMesh& mesh, const ObjectMedium& medium);

/// κ and μ at the centres of the voxels.
Medium medium_on(const BlockGrid& grid, const ObjectMedium& medium);

/// Between values on the pixels of all six faces, in all_faces' order, and values on the mesh's
/// triangles.
class FaceMap {
 public:
  FaceMap(const BlockGrid& grid, const TriangleMesh& mesh, const Surface& surface);

  std::size_t pixels() const { return pixel_area_.size(); }
  /// Means over the triangles of what is bilinear between the pixels' centres.
  std::vector<double> on_triangles(std::span<const double> on_pixels) const;
  /// Means over the pixels by the same weights.
  std::vector<double> on_pixels(std::span<const double> on_triangles) const;

 private:
  struct Share {
    std::uint32_t pixel = 0;
    double weight = 0.0;  ///< those of a triangle sum to one
  };
  std::vector<std::size_t> first_;  ///< of each triangle's shares
  std::vector<Share> shares_;
  std::vector<double> triangle_area_, pixel_area_;  ///< the latter as the shares cover it [mm²]
};

}  // namespace kappamu::forward::block
