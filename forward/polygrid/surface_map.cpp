#include "forward/polygrid/surface_map.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/equations/cell_integrals.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

/// Rows of pieces that a triangle is divided into, so that a piece is not longer than a side.
constexpr double least_gap = 0.3;  ///< as SurfaceMap::gaps() has it
constexpr int most_rows = 16;

/// The functions of a side's corners at a point of one of its triangles in surface_of_grid():
/// corners 0, 1, 2 and 0, 2, 3.
std::array<double, 4> functions_at(const ClosestPoint::Found& found) {
  const Vector3d& w = found.weights;
  return found.triangle % 2 == 0 ? side_functions(w[1] + w[2], w[2])
                                 : side_functions(w[1], w[1] + w[2]);
}

}  // namespace

SurfaceMap::SurfaceMap(const Polygrid& grid, const TriangleMesh& mesh, const Surface& surface)
    : side_of_(mesh.triangles.size()), gaps_(mesh.triangles.size()) {
  const std::size_t sides = grid.boundary_cell.size();
  double area = 0.0;
  for (const double a : grid.area) area += a;
  const double edge = std::sqrt(area / static_cast<double>(std::max<std::size_t>(1, sides)));
  const TriangleMesh faces = surface_of_grid(grid);
  const ClosestPoint of_sides(faces), of_mesh(mesh);

  std::vector<std::vector<Share>> shares(mesh.triangles.size());
  for_ranges(shares.size(), [&](std::size_t begin, std::size_t end) {
    int near = 0;
    const auto nearest = [&](const Vector3d& p) {
      const ClosestPoint::Found found = of_sides.from(p, near);
      near = found.triangle;
      return found;
    };
    for (std::size_t t = begin; t < end; ++t) {
      std::array<Vector3d, 3> facet;
      for (std::size_t i = 0; i < 3; ++i) {
        facet[i] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])];
      }
      const double longest = std::max({(facet[1] - facet[0]).norm(), (facet[2] - facet[1]).norm(),
                                       (facet[0] - facet[2]).norm()});
      const int rows = std::clamp(static_cast<int>(std::ceil(longest / edge)), 1, most_rows);
      // Middles of the rows² equal pieces, upright and turned.
      const double weight = 1.0 / (rows * rows);
      const auto add = [&](double u, double v) {
        const Vector3d p = (1 - u - v) * facet[0] + u * facet[1] + v * facet[2];
        const ClosestPoint::Found found = nearest(p);
        const std::array<double, 4> n = functions_at(found);
        const std::array<int, 4> corners =
            boundary_corners(grid, static_cast<std::size_t>(found.triangle / 2));
        for (std::size_t i = 0; i < 4; ++i) shares[t].push_back({corners[i], weight * n[i]});
      };
      for (int i = 0; i < rows; ++i) {
        for (int j = 0; i + j < rows; ++j) {
          add((i + 1.0 / 3.0) / rows, (j + 1.0 / 3.0) / rows);
          if (i + j + 1 < rows) add((i + 2.0 / 3.0) / rows, (j + 2.0 / 3.0) / rows);
        }
      }
      const auto found = nearest(surface.position[t]);
      side_of_[t] = found.triangle / 2;
      gaps_[t] = found.distance > least_gap * edge ? found.distance : 0.0;
    }
  });
  for (std::vector<Share>& mine : shares) {
    std::sort(mine.begin(), mine.end(),
              [](const Share& a, const Share& b) { return a.corner < b.corner; });
    for (const Share& share : mine) {
      if (shares_.size() > first_.back() && shares_.back().corner == share.corner) {
        shares_.back().weight += share.weight;
      } else {
        shares_.push_back(share);
      }
    }
    first_.push_back(shares_.size());
  }

  points_.resize(4 * sides);
  for_ranges(sides, [&](std::size_t begin, std::size_t end) {
    int near = 0;
    for (std::size_t b = begin; b < end; ++b) {
      const std::array<int, 4> corners = boundary_corners(grid, b);
      std::array<Vector3d, 4> p;
      for (std::size_t i = 0; i < 4; ++i) p[i] = grid.corner[static_cast<std::size_t>(corners[i])];
      const std::array<SidePoint, 4> of_side = side_points(p);
      for (std::size_t k = 0; k < 4; ++k) {
        const auto& n = of_side[k].function;
        near = of_mesh.from(n[0] * p[0] + n[1] * p[1] + n[2] * p[2] + n[3] * p[3], near).triangle;
        LitPoint& point = points_[4 * b + k];
        point.triangle = near;
        point.corner = corners;
        for (std::size_t i = 0; i < 4; ++i) point.area[i] = of_side[k].area * n[i];
      }
    }
  });
}

void SurfaceMap::on_triangles(std::span<const double> at_corners, std::span<double> means) const {
  for (std::size_t t = 0; t < means.size(); ++t) {
    means[t] = 0.0;
    for (std::size_t k = first_[t]; k < first_[t + 1]; ++k) {
      means[t] += shares_[k].weight * at_corners[static_cast<std::size_t>(shares_[k].corner)];
    }
  }
}

double SurfaceMap::add_loads(std::span<const double> on_triangles, double factor,
                             std::span<double> at_corners) const {
  double sum = 0.0;
  for (const LitPoint& point : points_) {
    const double value = on_triangles[static_cast<std::size_t>(point.triangle)];
    if (value == 0.0) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      at_corners[static_cast<std::size_t>(point.corner[i])] += factor * value * point.area[i];
      sum += value * point.area[i];
    }
  }
  return sum;
}

}  // namespace kappamu::forward::polygrid
