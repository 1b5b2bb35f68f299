#include "render/scene/shell.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/parallel.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/shape/make_polygrid.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr int cells = 6'000;
constexpr double most_voxels = 2e6;

/// The block's voxel that holds `at` [voxels], the block mirrored beyond its ends.
int mirrored(double at, int extent) {
  const double period = 2.0 * extent, within = at - period * std::floor(at / period);
  const int voxel = static_cast<int>(within < extent ? within : period - within);
  return std::clamp(voxel, 0, extent - 1);
}

class Shell {
 public:
  Shell(const GridShape& block, const TriangleMesh& mesh, const Vector3d& offset)
      : block_(block), offset_(offset) {
    Progress silent;
    forward::PolygridOptions options;
    options.cells = cells;
    grid_ = forward::make_polygrid(mesh, options, silent).grid;
    surface_ = forward::surface_of_grid(grid_);
    double area = 0.0;
    for (const double of_side : grid_.area) area += of_side;
    step_mm_ = std::sqrt(area / static_cast<double>(grid_.area.size()));
    closest_ = std::make_unique<forward::ClosestPoint>(surface_);
    for (std::size_t k = 0; k < grid_.boundary_cell.size(); ++k) {
      below_.push_back(block_voxel(k, {0.5, 0.5}, block_.nz * block_.voxel_mm));
    }
  }

  /// Where a point lies: the voxel of the block, or deeper.
  std::optional<std::size_t> voxel_of(const Vector3d& point) const {
    const auto found = closest_->from(point);
    const bool outside = (point - found.point).dot(closest_->normal(found.triangle)) > 0.0;
    const double depth = outside ? 0.0 : found.distance;
    if (depth >= block_.nz * block_.voxel_mm) return std::nullopt;
    // Triangles of a side: its corners 0, 1, 2 and 0, 2, 3.
    const Vector3d& w = found.weights;
    const Eigen::Vector2d on_side = found.triangle % 2 == 0 ? Eigen::Vector2d(w[1] + w[2], w[2])
                                                            : Eigen::Vector2d(w[1], w[1] + w[2]);
    return block_voxel(static_cast<std::size_t>(found.triangle / 2), on_side, depth);
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
  /// At a place on a side, in [0, 1]² from its first corner along its edges.
  std::size_t block_voxel(std::size_t side, const Eigen::Vector2d& on_side, double depth) const {
    const int axis = grid_.boundary_side[side] / 2;
    const std::array<int, 4> corners = forward::side_corners(grid_.boundary_side[side]);
    const Eigen::Vector3i& place = grid_.cell[static_cast<std::size_t>(grid_.boundary_cell[side])];
    std::array<double, 2> at{};
    for (int i = 0; i < 2; ++i) {
      const int along = (axis + 1 + i) % 3;
      const auto bit = [&](int c) { return corners[static_cast<std::size_t>(c)] >> along & 1; };
      const double local = bit(0) + (bit(1) - bit(0)) * on_side[0] + (bit(3) - bit(0)) * on_side[1];
      at[static_cast<std::size_t>(i)] =
          ((place[along] + local) * step_mm_ - offset_[i]) / block_.voxel_mm;
    }
    const int layer = std::min(static_cast<int>(depth / block_.voxel_mm), block_.nz - 1);
    return block_.index(mirrored(at[0], block_.nx), mirrored(at[1], block_.ny),
                        block_.nz - 1 - layer);
  }

  GridShape block_;
  Vector3d offset_;
  forward::Polygrid grid_;
  TriangleMesh surface_;
  double step_mm_ = 0.0;  ///< of the lattice on the surface
  std::unique_ptr<forward::ClosestPoint> closest_;
  std::vector<std::size_t> below_;  ///< [side] voxel of the block's last layer
};

}  // namespace

Wrapped wrapped(const io::VolumeSet& block, const TriangleMesh& mesh, const Vector3d& offset_mm) {
  const Shell shell(block.shape(), mesh, offset_mm);
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const double h = std::max(block.shape().voxel_mm, std::cbrt(box.volume() / most_voxels));
  const Eigen::Array3i n = (box.sizes() / h).array().ceil().cast<int>();
  const GridShape shape{n[0], n[1], n[2], h};
  Wrapped result{{}, box.min()};
  result.set.channels = block.channels;
  result.set.eta = block.eta;
  result.set.media.assign(block.media.size(),
                          {Volume<double>(shape, 0.0), Volume<double>(shape, 0.0)});
  for_rows(shape.nz * shape.ny, [&](int row) {
    for (int x = 0; x < shape.nx; ++x) {
      const int y = row % shape.ny, z = row / shape.ny;
      const Vector3d point = box.min() + h * Vector3d(x + 0.5, y + 0.5, z + 0.5);
      const std::size_t i = shape.index(x, y, z);
      const auto add = [&](double weight, std::size_t voxel) {
        for (std::size_t c = 0; c < block.media.size(); ++c) {
          result.set.media[c].kappa[i] += weight * block.media[c].kappa[voxel];
          result.set.media[c].mu[i] += weight * block.media[c].mu[voxel];
        }
      };
      if (const auto voxel = shell.voxel_of(point)) {
        add(1.0, *voxel);
      } else {
        shell.interpolate(point, add);
      }
    }
  });
  return result;
}

}  // namespace kappamu::render
