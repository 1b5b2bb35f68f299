#include "render/scene/shell.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "io/volume/volume_file.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr int cells = 6'000;
constexpr double most_voxels = 2e6;
/// Power of the normal's components by which the three views of a place are blended.
constexpr double sharpness = 8.0;

/// The block's voxel that holds `at` [voxels], the block mirrored beyond its ends.
int mirrored(double at, int extent) {
  const double period = 2.0 * extent, within = at - period * std::floor(at / period);
  const int voxel = static_cast<int>(within < extent ? within : period - within);
  return std::clamp(voxel, 0, extent - 1);
}

class Shell {
 public:
  Shell(const GridShape& block, const TriangleMesh& mesh, const Vector3d& offset,
        const Polycube* drawn)
      : block_(block), offset_(offset) {
    Progress silent;
    forward::PolygridOptions options;
    options.cells = cells;
    options.drawn = drawn;
    grid_ = forward::make_polygrid(mesh, options, silent).grid;
    surface_ = forward::surface_of_grid(grid_);
    closest_ = std::make_unique<forward::ClosestPoint>(surface_);
    for (std::size_t k = 0; k < grid_.boundary_cell.size(); ++k) {
      Eigen::Index axis = 0;
      grid_.normal[k].cwiseAbs().maxCoeff(&axis);
      below_.push_back(block_voxel(grid_.boundary_node[k], axis, block_.nz * block_.voxel_mm));
    }
  }

  /// Calls add(weight, voxel) for the voxels of the block that lie at a point; weights sum to one.
  /// False: it lies deeper.
  template <class Add>
  bool place(const Vector3d& point, const Add& add) const {
    const auto found = closest_->from(point);
    const bool outside = (point - found.point).dot(closest_->normal(found.triangle)) > 0.0;
    const double depth = outside ? 0.0 : found.distance;
    if (depth >= block_.nz * block_.voxel_mm) return false;
    const Eigen::Array3d weight = closest_->smooth_normal(found).array().abs().pow(sharpness);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      add(weight[axis] / weight.sum(), block_voxel(found.point, axis, depth));
    }
    return true;
  }

  /// Calls add(weight, voxel) for the block's last layer below every side; weights sum to one.
  template <class Add>
  void interpolate(const Vector3d& point, const Add& add) const {
    double sum = 0.0;
    std::vector<double> weight(below_.size());
    for (std::size_t k = 0; k < weight.size(); ++k) {
      const Vector3d way = grid_.boundary_node[k] - point;
      const double squared = way.squaredNorm();
      // Solid angle over distance.
      weight[k] = grid_.area[k] * std::max(0.0, way.dot(grid_.normal[k])) / (squared * squared);
      sum += weight[k];
    }
    for (std::size_t k = 0; k < weight.size(); ++k) {
      if (weight[k] > 0.0) add(weight[k] / sum, below_[k]);
    }
  }

 private:
  /// At a place of the surface, seen along an axis.
  std::size_t block_voxel(const Vector3d& place, Eigen::Index axis, double depth) const {
    std::array<double, 2> voxel{};
    for (Eigen::Index i = 0; i < 2; ++i) {
      voxel[static_cast<std::size_t>(i)] =
          (place[(axis + 1 + i) % 3] - offset_[i]) / block_.voxel_mm;
    }
    const int layer = std::min(static_cast<int>(depth / block_.voxel_mm), block_.nz - 1);
    return block_.index(mirrored(voxel[0], block_.nx), mirrored(voxel[1], block_.ny),
                        block_.nz - 1 - layer);
  }

  GridShape block_;
  Vector3d offset_;
  forward::Polygrid grid_;
  TriangleMesh surface_;
  std::unique_ptr<forward::ClosestPoint> closest_;
  std::vector<std::size_t> below_;  ///< [side] voxel of the block's last layer
};

}  // namespace

double smallest_voxel(const Vector3d& box) {
  return std::cbrt(box.prod() / most_voxels);
}

GridShape voxels_of(const Vector3d& box, double voxel_mm) {
  constexpr double channels = 3.0, largest_extent = 65536.0;
  const Eigen::Array3d n = (box / voxel_mm).array().ceil().max(1.0);
  if (n.maxCoeff() > largest_extent ||
      2.0 * channels * n.prod() > static_cast<double>(io::default_most_voxels)) {
    throw InputError("voxels of " + std::to_string(voxel_mm) + " mm are too many for it (" +
                     std::to_string(n.prod()) + "); write a larger voxel_mm");
  }
  return {static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2]), voxel_mm};
}

io::VolumeSet wrapped(const io::VolumeSet& block, const TriangleMesh& mesh,
                      const Vector3d& offset_mm, const Polycube* drawn,
                      std::optional<double> voxel_mm) {
  const Shell shell(block.shape(), mesh, offset_mm, drawn);
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const GridShape shape =
      voxels_of(box.sizes(),
                voxel_mm.value_or(std::max(block.shape().voxel_mm, smallest_voxel(box.sizes()))));
  const Eigen::Array3d step = box.sizes().array() / Eigen::Array3d(shape.nx, shape.ny, shape.nz);
  io::VolumeSet result;
  result.channels = block.channels;
  result.eta = block.eta;
  result.media.assign(block.media.size(), {Volume<double>(shape, 0.0), Volume<double>(shape, 0.0)});
  for_rows(shape.nz * shape.ny, [&](int row) {
    for (int x = 0; x < shape.nx; ++x) {
      const int y = row % shape.ny, z = row / shape.ny;
      const Vector3d point = box.min().array() + step * Eigen::Array3d(x + 0.5, y + 0.5, z + 0.5);
      const std::size_t i = shape.index(x, y, z);
      const auto add = [&](double weight, std::size_t voxel) {
        for (std::size_t c = 0; c < block.media.size(); ++c) {
          result.media[c].kappa[i] += weight * block.media[c].kappa[voxel];
          result.media[c].mu[i] += weight * block.media[c].mu[voxel];
        }
      };
      if (!shell.place(point, add)) shell.interpolate(point, add);
    }
  });
  return result;
}

}  // namespace kappamu::render
