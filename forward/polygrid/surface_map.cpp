#include "forward/polygrid/surface_map.h"

#include <algorithm>
#include <cmath>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/polygrid/equations/cell_integrals.h"
#include "forward/polygrid/nearest_facet.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

/// Rows of pieces that a triangle is divided into, so that a piece is not longer than a side.
constexpr int most_rows = 16;
const std::array<double, 2> gauss{0.5 - std::sqrt(1.0 / 12.0), 0.5 + std::sqrt(1.0 / 12.0)};

/// Corners of the boundary's sides, as side_corners() orders them.
std::vector<std::array<int, 4>> sides_of(const Polygrid& grid) {
  std::vector<std::array<int, 4>> sides(grid.boundary_cell.size());
  for (std::size_t b = 0; b < sides.size(); ++b) {
    const auto& corners = grid.cell_corners[static_cast<std::size_t>(grid.boundary_cell[b])];
    const std::array<int, 4> of_side = side_corners(grid.boundary_side[b]);
    for (std::size_t i = 0; i < 4; ++i) sides[b][i] = corners[static_cast<std::size_t>(of_side[i])];
  }
  return sides;
}

/// Two triangles a side: corners 0, 1, 3 and 0, 3, 2.
constexpr std::array<std::array<std::size_t, 3>, 2> halves{{{0, 1, 3}, {0, 3, 2}}};

/// The bilinear functions of a side's corners at a point of one of its halves.
std::array<double, 4> functions_at(std::size_t half, const Vector3d& weights) {
  double u = 0.0, v = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t corner = halves[half][i];
    const double weight = weights[static_cast<Eigen::Index>(i)];
    u += (corner & 1) != 0 ? weight : 0.0;
    v += (corner & 2) != 0 ? weight : 0.0;
  }
  return {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
}

}  // namespace

SurfaceMap::SurfaceMap(const Polygrid& grid, const TriangleMesh& mesh, const Surface& surface)
    : side_of_(mesh.triangles.size()), corners_(grid.corner.size()) {
  const std::vector<std::array<int, 4>> sides = sides_of(grid);
  const auto corner = [&](int i) -> const Vector3d& {
    return grid.corner[static_cast<std::size_t>(i)];
  };
  double area = 0.0;
  for (const double a : grid.area) area += a;
  const double edge = std::sqrt(area / static_cast<double>(std::max<std::size_t>(1, sides.size())));

  std::vector<Facet> of_sides;
  const std::vector<Facet> of_mesh = facets_of(mesh);
  for (const auto& side : sides) {
    for (const auto& half : halves) {
      of_sides.push_back({corner(side[half[0]]), corner(side[half[1]]), corner(side[half[2]])});
    }
  }
  const Facets side_facets(of_sides, edge), mesh_facets(of_mesh, edge);

  std::vector<std::vector<Share>> shares(mesh.triangles.size());
  embedded::for_row_ranges(shares.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Facet& facet = of_mesh[t];
      const double longest = std::max({(facet[1] - facet[0]).norm(), (facet[2] - facet[1]).norm(),
                                       (facet[0] - facet[2]).norm()});
      const int rows = std::clamp(static_cast<int>(std::ceil(longest / edge)), 1, most_rows);
      // Middles of the rows² equal pieces, upright and turned.
      const double weight = 1.0 / (rows * rows);
      const auto add = [&](double u, double v) {
        const Vector3d p = (1 - u - v) * facet[0] + u * facet[1] + v * facet[2];
        const auto nearest = side_facets.nearest(p);
        const auto side = static_cast<std::size_t>(nearest.facet / 2);
        const std::array<double, 4> n =
            functions_at(static_cast<std::size_t>(nearest.facet % 2), nearest.weights);
        for (std::size_t i = 0; i < 4; ++i) shares[t].push_back({sides[side][i], weight * n[i]});
      };
      for (int i = 0; i < rows; ++i) {
        for (int j = 0; i + j < rows; ++j) {
          add((i + 1.0 / 3.0) / rows, (j + 1.0 / 3.0) / rows);
          if (i + j + 1 < rows) add((i + 2.0 / 3.0) / rows, (j + 2.0 / 3.0) / rows);
        }
      }
      side_of_[t] = side_facets.nearest(surface.position[t]).facet / 2;
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

  points_.resize(4 * sides.size());
  embedded::for_row_ranges(points_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const auto& side = sides[k / 4];
      const double u = gauss[k & 1], v = gauss[k >> 1 & 1];
      const std::array<double, 4> n{(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
      const std::array<Vector3d, 4> p{corner(side[0]), corner(side[1]), corner(side[2]),
                                      corner(side[3])};
      const Vector3d along_u = (1 - v) * (p[1] - p[0]) + v * (p[3] - p[2]);
      const Vector3d along_v = (1 - u) * (p[2] - p[0]) + u * (p[3] - p[1]);
      const double weight = 0.25 * along_u.cross(along_v).norm();
      Vector3d at = Vector3d::Zero();
      for (std::size_t i = 0; i < 4; ++i) at += n[i] * p[i];
      points_[k].triangle = mesh_facets.nearest(at).facet;
      points_[k].corner = side;
      for (std::size_t i = 0; i < 4; ++i) points_[k].area[i] = weight * n[i];
    }
  });
}

std::vector<double> SurfaceMap::on_triangles(std::span<const double> at_corners) const {
  std::vector<double> result(first_.size() - 1, 0.0);
  for (std::size_t t = 0; t < result.size(); ++t) {
    for (std::size_t k = first_[t]; k < first_[t + 1]; ++k) {
      result[t] += shares_[k].weight * at_corners[static_cast<std::size_t>(shares_[k].corner)];
    }
  }
  return result;
}

std::vector<double> SurfaceMap::loads(std::span<const double> on_triangles) const {
  std::vector<double> result(corners_, 0.0);
  for (const SidePoint& point : points_) {
    const double value = on_triangles[static_cast<std::size_t>(point.triangle)];
    for (std::size_t i = 0; i < 4; ++i) {
      result[static_cast<std::size_t>(point.corner[i])] += value * point.area[i];
    }
  }
  return result;
}

}  // namespace kappamu::forward::polygrid
