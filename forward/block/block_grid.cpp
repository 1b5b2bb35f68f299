#include "forward/block/block_grid.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace kappamu::forward::block {

namespace {

using Eigen::Vector3d;

/// Of the box's longest edge: how far a corner may lie from where it should.
constexpr double slack = 1e-6;
/// Voxels along the longest edge of a homogeneous box.
constexpr int fewest_voxels = 32, most_voxels = 128;
/// A triangle's mean is taken over pieces no longer than this many pixels, in at most so many rows.
constexpr double piece_pixels = 0.5;
constexpr int most_rows = 64;

/// The face that a triangle lies on.
std::optional<Face> face_of(const TriangleMesh& mesh, std::size_t triangle, const Vector3d& normal,
                            const Eigen::AlignedBox3d& box) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const bool plus = normal[axis] > 0.0;
  const double plane = (plus ? box.max() : box.min())[axis];
  for (const int vertex : mesh.triangles[triangle]) {
    const double off = mesh.vertices[static_cast<std::size_t>(vertex)][axis] - plane;
    if (std::abs(off) > slack * box.sizes().maxCoeff()) return std::nullopt;
  }
  return all_faces[static_cast<std::size_t>(2 * axis + (plus ? 1 : 0))];
}

bool is_box(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  const Surface surface = surface_of(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (surface.area[t] > 0.0 && !face_of(mesh, t, surface.normal[t], box)) return false;
  }
  return std::abs(enclosed_volume(mesh) - box.volume()) <= slack * box.volume();
}

std::optional<GridShape> voxels_of(const Vector3d& edges, double h) {
  const Eigen::Array3d count = (edges / h).array().round();
  if ((count < 1.0).any() || (count > 4096.0).any()) return std::nullopt;
  if (((edges.array() - count * h).abs() > slack * edges.maxCoeff()).any()) return std::nullopt;
  return GridShape{static_cast<int>(count[0]), static_cast<int>(count[1]),
                   static_cast<int>(count[2]), h};
}

std::pair<int, int> axes_of(Face face) {
  constexpr std::array<std::pair<int, int>, 3> axes{{{1, 2}, {0, 2}, {0, 1}}};
  return axes[static_cast<std::size_t>(axis_of(face))];
}

}  // namespace

std::optional<BlockGrid> block_grid(const TriangleMesh& mesh, const ObjectMedium& medium) {
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  if (mesh.triangles.empty() || !is_box(mesh, box)) return std::nullopt;
  const double longest = box.sizes().maxCoeff();
  std::optional<GridShape> shape;
  if (medium.voxel_mm()) {
    shape = voxels_of(box.sizes(), *medium.voxel_mm());
  } else {
    for (int n = fewest_voxels; n <= most_voxels && !shape; ++n) {
      shape = voxels_of(box.sizes(), longest / n);
    }
  }
  if (!shape) return std::nullopt;
  return BlockGrid{*shape, box.min()};
}

BlockGrid require_block_grid(const TriangleMesh& mesh, const ObjectMedium& medium) {
  if (const std::optional<BlockGrid> grid = block_grid(mesh, medium)) return *grid;
  throw InputError(
      "model 'grid' answers for boxes along the axes whose edges are whole numbers of the volume's "
      "voxels; take 'embedded'");
}

Medium medium_on(const BlockGrid& grid, const ObjectMedium& medium) {
  const GridShape& shape = grid.shape;
  Medium result{Volume<double>(shape), Volume<double>(shape)};
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const Vector3d centre = shape.voxel_mm * Vector3d(x + 0.5, y + 0.5, z + 0.5);
        const Coefficients here = medium.at(grid.corner + centre);
        result.kappa(x, y, z) = here.kappa;
        result.mu(x, y, z) = here.mu;
      }
    }
  }
  return result;
}

FaceMap::FaceMap(const BlockGrid& grid, const TriangleMesh& mesh, const Surface& surface)
    : first_{0}, triangle_area_(surface.area) {
  std::array<std::size_t, 6> offset{};
  std::size_t pixels = 0;
  for (std::size_t f = 0; f < 6; ++f) {
    offset[f] = pixels;
    pixels += face_shape(grid.shape, all_faces[f]).cells();
  }
  pixel_area_.assign(pixels, 0.0);
  const double h = grid.shape.voxel_mm;
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::optional<Face> face = face_of(mesh, t, surface.normal[t], box);
    const std::size_t begin = shares_.size();
    if (face) {
      const FaceShape shape = face_shape(grid.shape, *face);
      const auto [u, v] = axes_of(*face);
      std::array<Vector3d, 3> corner;
      for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])] - grid.corner;
      }
      const double longest =
          std::max({(corner[1] - corner[0]).norm(), (corner[2] - corner[1]).norm(),
                    (corner[0] - corner[2]).norm()});
      const int rows =
          std::clamp(static_cast<int>(std::ceil(longest / (piece_pixels * h))), 1, most_rows);
      const double each = 1.0 / (rows * rows);
      const auto add = [&](int column, int row, double weight) {
        column = std::clamp(column, 0, shape.nu - 1);
        row = std::clamp(row, 0, shape.nv - 1);
        const std::size_t pixel = offset[static_cast<std::size_t>(*face)] +
                                  static_cast<std::size_t>(row * shape.nu + column);
        if (weight > 0.0) shares_.push_back({static_cast<std::uint32_t>(pixel), weight});
      };
      const auto add_point = [&](double second, double third) {
        const Vector3d point =
            corner[0] + second * (corner[1] - corner[0]) + third * (corner[2] - corner[0]);
        const double at_u = point[u] / h - 0.5, at_v = point[v] / h - 0.5;
        const int i = static_cast<int>(std::floor(at_u)), j = static_cast<int>(std::floor(at_v));
        const double s = at_u - i, r = at_v - j;
        add(i, j, each * (1.0 - s) * (1.0 - r));
        add(i + 1, j, each * s * (1.0 - r));
        add(i, j + 1, each * (1.0 - s) * r);
        add(i + 1, j + 1, each * s * r);
      };
      for (int i = 0; i < rows; ++i) {
        for (int j = 0; i + j < rows; ++j) {
          add_point((i + 1.0 / 3.0) / rows, (j + 1.0 / 3.0) / rows);
          if (i + j + 1 < rows) add_point((i + 2.0 / 3.0) / rows, (j + 2.0 / 3.0) / rows);
        }
      }
    }
    // One share per pixel.
    const auto from = shares_.begin() + static_cast<std::ptrdiff_t>(begin);
    std::sort(from, shares_.end(),
              [](const Share& a, const Share& b) { return a.pixel < b.pixel; });
    auto last = from;
    for (auto share = from; share != shares_.end(); ++share) {
      if (share != from && share->pixel == last->pixel) {
        last->weight += share->weight;
      } else {
        if (share != from) ++last;
        *last = *share;
      }
    }
    if (from != shares_.end()) shares_.erase(last + 1, shares_.end());
    for (std::size_t s = begin; s < shares_.size(); ++s) {
      pixel_area_[shares_[s].pixel] += surface.area[t] * shares_[s].weight;
    }
    first_.push_back(shares_.size());
  }
}

std::vector<double> FaceMap::on_triangles(std::span<const double> on_pixels) const {
  std::vector<double> result(triangle_area_.size(), 0.0);
  for (std::size_t t = 0; t < result.size(); ++t) {
    for (std::size_t s = first_[t]; s < first_[t + 1]; ++s) {
      result[t] += shares_[s].weight * on_pixels[shares_[s].pixel];
    }
  }
  return result;
}

std::vector<double> FaceMap::on_pixels(std::span<const double> on_triangles) const {
  std::vector<double> result(pixel_area_.size(), 0.0);
  for (std::size_t t = 0; t < triangle_area_.size(); ++t) {
    for (std::size_t s = first_[t]; s < first_[t + 1]; ++s) {
      result[shares_[s].pixel] += triangle_area_[t] * shares_[s].weight * on_triangles[t];
    }
  }
  for (std::size_t p = 0; p < result.size(); ++p) {
    if (pixel_area_[p] > 0.0) result[p] /= pixel_area_[p];
  }
  return result;
}

}  // namespace kappamu::forward::block
