#include "forward/polygrid/shape/measure_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/shape/place_nodes.h"

namespace kappamu::forward {

using Eigen::Vector3d;

namespace {

/// Standard deviation over mean.
double spread(const std::vector<double>& values) {
  double sum = 0.0, squares = 0.0;
  for (const double value : values) sum += value;
  const double mean = sum / static_cast<double>(values.size());
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size())) / mean;
}

/// Largest over smallest of a cell's edges, each the mean along one axis.
double aspect(const Polygrid& grid, std::size_t cell) {
  std::array<double, 3> length{};
  for (int b = 0; b < 8; ++b) {
    for (int axis = 0; axis < 3; ++axis) {
      if ((b >> axis & 1) != 0) continue;
      const auto corner = [&](int bits) {
        return grid.corner[static_cast<std::size_t>(
            grid.cell_corners[cell][static_cast<std::size_t>(bits)])];
      };
      length[static_cast<std::size_t>(axis)] += (corner(b | 1 << axis) - corner(b)).norm();
    }
  }
  const auto [least, most] = std::minmax_element(length.begin(), length.end());
  return *most / *least;
}

}  // namespace

PolygridQuality measure_quality(const Polygrid& grid, const TriangleMesh& mesh) {
  PolygridQuality quality;
  quality.cells = static_cast<int>(grid.cell.size());
  quality.boundary_nodes = static_cast<int>(grid.boundary_cell.size());
  quality.least_jacobian = 1.0;
  const double share = 1.0 / quality.cells;
  std::vector<double> volumes;
  double volume = 0.0;
  for (std::size_t i = 0; i < grid.cell.size(); ++i) {
    const double jacobian = scaled_jacobian(grid, i);
    quality.least_jacobian = std::min(quality.least_jacobian, jacobian);
    quality.mean_jacobian += share * jacobian;
    if (!(jacobian > 0.0)) ++quality.inverted;
    quality.mean_aspect += share * aspect(grid, i);
    volumes.push_back(cell_volume(grid, i));
    volume += volumes.back();
  }
  quality.volume_spread = spread(volumes);
  quality.volume_ratio = volume / enclosed_volume(mesh);

  const TriangleMesh own = surface_of_grid(grid);
  const ClosestPoint surface(own);
  const double spacing = boundary_spacing(grid);
  const Surface samples = surface_of(mesh);
  int near = 0;
  const auto gap = [&](const Vector3d& point) {
    const auto found = surface.from(point, near);
    near = found.triangle;
    quality.largest_gap = std::max(quality.largest_gap, found.distance / spacing);
    return found.distance / spacing;
  };
  double area = 0.0;
  for (std::size_t t = 0; t < samples.size(); ++t) {
    quality.mean_gap += samples.area[t] * gap(samples.position[t]);
    area += samples.area[t];
  }
  quality.mean_gap /= area;
  for (const Vector3d& vertex : mesh.vertices) gap(vertex);
  return quality;
}

}  // namespace kappamu::forward
