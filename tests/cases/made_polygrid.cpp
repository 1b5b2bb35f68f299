#include "tests/cases/made_polygrid.h"

#include <cmath>

#include "forward/polygrid/split_polygrid.h"

namespace kappamu::forward::polygrid {

using Eigen::Vector3d;
using Eigen::Vector3i;

Polygrid mapped_box(const Vector3i& n, const Map& map) {
  std::vector<Vector3d> corner;
  for (int z = 0; z <= n[2]; ++z) {
    for (int y = 0; y <= n[1]; ++y) {
      for (int x = 0; x <= n[0]; ++x) {
        corner.push_back(map(Vector3d(x, y, z).cwiseQuotient(n.cast<double>())));
      }
    }
  }
  std::vector<Vector3i> cell;
  std::vector<std::array<int, 8>> cell_corners;
  for (int z = 0; z < n[2]; ++z) {
    for (int y = 0; y < n[1]; ++y) {
      for (int x = 0; x < n[0]; ++x) {
        std::array<int, 8> corners{};
        for (int c = 0; c < 8; ++c) {
          const Vector3i at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2 & 1));
          corners[static_cast<std::size_t>(c)] = (at[2] * (n[1] + 1) + at[1]) * (n[0] + 1) + at[0];
        }
        cell.push_back({x, y, z});
        cell_corners.push_back(corners);
      }
    }
  }
  return linked(std::move(cell), std::move(cell_corners), std::move(corner));
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

}  // namespace kappamu::forward::polygrid
