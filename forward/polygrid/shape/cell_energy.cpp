#include "forward/polygrid/shape/cell_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace kappamu::forward {

using Eigen::Vector3d;

namespace {

/// The edges at corner `b` along the cell's axes, over those of the target: the columns of J.
std::array<Vector3d, 3> edges_at(const std::array<Vector3d, 8>& x, unsigned b,
                                 const TargetCell& target) {
  std::array<Vector3d, 3> edges;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double sign = (b >> axis & 1U) != 0 ? -1.0 : 1.0;
    edges[axis] = sign * target.inverse_edge[axis] * (x[b ^ 1U << axis] - x[b]);
  }
  return edges;
}

std::array<Vector3d, 8> corners_of(const std::array<int, 8>& cell,
                                   const std::vector<Vector3d>& corner) {
  std::array<Vector3d, 8> x;
  for (std::size_t b = 0; b < 8; ++b) x[b] = corner[static_cast<std::size_t>(cell[b])];
  return x;
}

}  // namespace

double CellEnergy::operator()(const std::vector<std::array<int, 8>>& cells,
                              const std::vector<TargetCell>& targets,
                              const std::vector<Vector3d>& corner,
                              std::vector<Vector3d>& gradient) const {
  double total = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::array<Vector3d, 8> x = corners_of(cells[i], corner);
    const TargetCell& target = targets[i];
    std::array<Vector3d, 8> g;
    g.fill(Vector3d::Zero());
    for (unsigned b = 0; b < 8; ++b) {
      const auto [u, v, w] = edges_at(x, b, target);
      const Vector3d vw = v.cross(w);
      const double s = (u.squaredNorm() + v.squaredNorm() + w.squaredNorm()) / 3.0;
      const double d = u.dot(vw), root = std::sqrt(epsilon * epsilon + d * d);
      const double chi = (d + root) / 2.0;
      if (!(chi > 0.0)) return std::numeric_limits<double>::infinity();
      const double shape = s * std::sqrt(s) / chi;
      const double size = (d * d + 1.0) / (2.0 * chi);
      const double energy = shape + size_weight * size;
      double outer = 1.0, raised = energy;
      for (int k = 1; k < power; ++k) {
        outer = (k + 1) * raised;
        raised *= energy;
      }
      total += raised;
      // d shape/ds per column (s is a third of |J|²), and d energy/dd.
      const double by_s = outer * std::sqrt(s) / chi;
      const double by_d = outer * (-shape / root + size_weight * (d / chi - size / root));
      const std::array<Vector3d, 3> by_edge{by_s * u + by_d * vw, by_s * v + by_d * w.cross(u),
                                            by_s * w + by_d * u.cross(v)};
      for (unsigned axis = 0; axis < 3; ++axis) {
        const double sign = (b >> axis & 1U) != 0 ? -1.0 : 1.0;
        const Vector3d force = sign * target.inverse_edge[axis] * by_edge[axis];
        g[b ^ 1U << axis] += force;
        g[b] -= force;
      }
    }
    for (std::size_t b = 0; b < 8; ++b) gradient[static_cast<std::size_t>(cells[i][b])] += g[b];
  }
  return total;
}

double least_determinant(const std::vector<std::array<int, 8>>& cells,
                         const std::vector<TargetCell>& targets,
                         const std::vector<Vector3d>& corner) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::array<Vector3d, 8> x = corners_of(cells[i], corner);
    for (unsigned b = 0; b < 8; ++b) {
      const auto [u, v, w] = edges_at(x, b, targets[i]);
      least = std::min(least, u.dot(v.cross(w)));
    }
  }
  return least;
}

}  // namespace kappamu::forward
