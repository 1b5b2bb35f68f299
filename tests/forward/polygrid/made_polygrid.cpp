#include "made_polygrid.h"

#include <cmath>

#include "forward/polygrid/equations/cell_integrals.h"

namespace kappamu::forward::polygrid {

using Eigen::Vector3d;
using Eigen::Vector3i;

Polygrid mapped_box(const Vector3i& n, const Map& map) {
  Polygrid grid;
  for (int z = 0; z <= n[2]; ++z) {
    for (int y = 0; y <= n[1]; ++y) {
      for (int x = 0; x <= n[0]; ++x) {
        grid.corner.push_back(map(Vector3d(x, y, z).cwiseQuotient(n.cast<double>())));
      }
    }
  }
  const auto index = [](const Vector3i& at, const Vector3i& extent) {
    return (at[2] * extent[1] + at[1]) * extent[0] + at[0];
  };
  for (int z = 0; z < n[2]; ++z) {
    for (int y = 0; y < n[1]; ++y) {
      for (int x = 0; x < n[0]; ++x) {
        const Vector3i at(x, y, z);
        std::array<int, 8> corners{};
        Vector3d middle = Vector3d::Zero();
        for (int c = 0; c < 8; ++c) {
          corners[static_cast<std::size_t>(c)] =
              index(at + Vector3i(c & 1, c >> 1 & 1, c >> 2 & 1), n + Vector3i::Ones());
          middle += grid.corner[static_cast<std::size_t>(corners[static_cast<std::size_t>(c)])] / 8;
        }
        std::array<int, 6> links{};
        for (int side = 0; side < 6; ++side) {
          Vector3i beside = at;
          beside[side / 2] += (side & 1) != 0 ? 1 : -1;
          const bool inside = (beside.array() >= 0).all() && (beside.array() < n.array()).all();
          links[static_cast<std::size_t>(side)] =
              inside ? index(beside, n) : ~static_cast<int>(grid.boundary_cell.size());
          if (inside) continue;
          const std::array<int, 4> of_side = side_corners(side);
          std::array<Vector3d, 4> p;
          for (std::size_t i = 0; i < 4; ++i) {
            const int corner = corners[static_cast<std::size_t>(of_side[i])];
            p[i] = grid.corner[static_cast<std::size_t>(corner)];
          }
          const Vector3d area = 0.5 * (p[3] - p[0]).cross(p[2] - p[1]);
          const Vector3d centre = 0.25 * (p[0] + p[1] + p[2] + p[3]);
          grid.boundary_node.push_back(centre);
          grid.normal.push_back((area.dot(centre - middle) > 0.0 ? 1.0 : -1.0) *
                                area.normalized());
          grid.area.push_back(area.norm());
          grid.boundary_cell.push_back(static_cast<int>(grid.cell.size()));
          grid.boundary_side.push_back(side);
        }
        grid.cell.push_back(at);
        grid.cell_corners.push_back(corners);
        grid.link.push_back(links);
        grid.node.push_back(middle);
      }
    }
  }
  return grid;
}

Polygrid box_polygrid(const Vector3i& n, const Vector3d& size) {
  return mapped_box(n, [&](const Vector3d& at) -> Vector3d { return at.cwiseProduct(size); });
}

Polygrid bent_polygrid(const Vector3i& n) {
  return mapped_box(n, [](const Vector3d& at) {
    const double x = at[0], y = at[1], z = at[2];
    return Vector3d(4.0 * x + 0.5 * y + 0.4 * std::sin(3.0 * z),
                    3.0 * y + 0.4 * std::sin(2.0 * x) - 0.3 * z,
                    2.0 * z + 0.3 * std::cos(3.0 * y) + 0.4 * x * x);
  });
}

Polygrid ball_polygrid(int n, double radius) {
  return mapped_box({n, n, n}, [&](const Vector3d& at) -> Vector3d {
    const Eigen::Array3d p = 2.0 * at.array() - 1.0, s = p * p;
    const auto factor = [&](int a, int b) {
      return std::sqrt(1.0 - s[a] / 2.0 - s[b] / 2.0 + s[a] * s[b] / 3.0);
    };
    return radius * Vector3d(p[0] * factor(1, 2), p[1] * factor(2, 0), p[2] * factor(0, 1));
  });
}

TriangleMesh surface_mesh(const Polygrid& grid) {
  TriangleMesh mesh{grid.corner, {}};
  for (std::size_t b = 0; b < grid.boundary_cell.size(); ++b) {
    const auto& corners = grid.cell_corners[static_cast<std::size_t>(grid.boundary_cell[b])];
    std::array<int, 4> at{};
    for (std::size_t i = 0; i < 4; ++i) {
      at[i] = corners[static_cast<std::size_t>(side_corners(grid.boundary_side[b])[i])];
    }
    const auto point = [&](int i) { return grid.corner[static_cast<std::size_t>(i)]; };
    const Vector3d across = (point(at[1]) - point(at[0])).cross(point(at[2]) - point(at[0]));
    const bool outward = across.dot(grid.normal[b]) > 0.0;
    mesh.triangles.push_back({at[0], at[outward ? 1 : 2], at[outward ? 2 : 1]});
    mesh.triangles.push_back({at[3], at[outward ? 2 : 1], at[outward ? 1 : 2]});
  }
  return mesh;
}

}  // namespace kappamu::forward::polygrid
