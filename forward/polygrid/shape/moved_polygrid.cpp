#include "forward/polygrid/shape/moved_polygrid.h"

#include <Eigen/SparseCore>
#include <set>

#include "core/numbers/conjugate_gradients.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/shape/place_nodes.h"

namespace kappamu::forward {

namespace {

using Eigen::Vector3d;

constexpr double least_jacobian_kept = 0.1;
/// Of displacements, relative: a thousandth of a cell at steps of a cell.
constexpr double extension_tolerance = 1e-3;
constexpr int most_steps = 500;

/// Which corners lie on the boundary, and by how much they move there.
std::vector<std::optional<Vector3d>> outer_moves(const Polygrid& grid, const TriangleMesh& from,
                                                 const TriangleMesh& to) {
  const ClosestPoint surface(from);
  std::vector<std::optional<Vector3d>> moves(grid.corner.size());
  int near = 0;
  for (std::size_t b = 0; b < grid.boundary_cell.size(); ++b) {
    const auto cell = static_cast<std::size_t>(grid.boundary_cell[b]);
    const int side = grid.boundary_side[b];
    for (int c = 0; c < 8; ++c) {
      if ((c >> (side / 2) & 1) != side % 2) continue;
      const auto corner =
          static_cast<std::size_t>(grid.cell_corners[cell][static_cast<std::size_t>(c)]);
      if (moves[corner]) continue;
      const ClosestPoint::Found found = surface.from(grid.corner[corner], near);
      near = found.triangle;
      Vector3d move = Vector3d::Zero();
      for (int k = 0; k < 3; ++k) {
        const auto vertex = static_cast<std::size_t>(
            from.triangles[static_cast<std::size_t>(near)][static_cast<std::size_t>(k)]);
        move += found.weights[k] * (to.vertices[vertex] - from.vertices[vertex]);
      }
      moves[corner] = move;
    }
  }
  return moves;
}

std::set<std::pair<int, int>> edges_of(const Polygrid& grid) {
  std::set<std::pair<int, int>> edges;
  for (const auto& corners : grid.cell_corners) {
    for (std::size_t c = 0; c < 8; ++c) {
      for (std::size_t bit = 1; bit < 8; bit *= 2) {
        if ((c & bit) == 0) edges.insert(std::minmax(corners[c], corners[c | bit]));
      }
    }
  }
  return edges;
}

/// Moves of all corners: those of the outer ones, and inside the solution of the graph's Laplace
/// equation.
std::vector<Vector3d> extended(const Polygrid& grid,
                               const std::vector<std::optional<Vector3d>>& outer) {
  std::vector<int> unknown(outer.size(), -1);
  int unknowns = 0;
  for (std::size_t c = 0; c < outer.size(); ++c) {
    if (!outer[c]) unknown[c] = unknowns++;
  }
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(unknowns, 3);
  for (const auto& [a, b] : edges_of(grid)) {
    for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
      const int row = unknown[static_cast<std::size_t>(one)];
      if (row < 0) continue;
      entries.emplace_back(row, row, 1.0);
      const auto& known = outer[static_cast<std::size_t>(other)];
      if (known) {
        right.row(row) += known->transpose();
      } else {
        entries.emplace_back(row, unknown[static_cast<std::size_t>(other)], -1.0);
      }
    }
  }
  Eigen::SparseMatrix<double> laplacian(unknowns, unknowns);
  laplacian.setFromTriplets(entries.begin(), entries.end());
  Eigen::MatrixX3d inside(unknowns, 3);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd b = right.col(axis);
    inside.col(axis) =
        conjugate_gradients(
            [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return laplacian * x; }, b,
            most_steps,
            [&](const GradientStep& step) { return step.rest <= extension_tolerance * b.norm(); })
            .x;
  }
  std::vector<Vector3d> moves(outer.size());
  for (std::size_t c = 0; c < outer.size(); ++c) {
    moves[c] = outer[c] ? *outer[c] : Vector3d(inside.row(unknown[c]).transpose());
  }
  return moves;
}

}  // namespace

std::optional<Polygrid> moved_polygrid(Polygrid grid, const TriangleMesh& from,
                                       const TriangleMesh& to, double first_layer) {
  const std::vector<Vector3d> moves = extended(grid, outer_moves(grid, from, to));
  for (std::size_t c = 0; c < moves.size(); ++c) grid.corner[c] += moves[c];
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    if (scaled_jacobian(grid, k) < least_jacobian_kept) return std::nullopt;
  }
  place_nodes(grid, ClosestPoint(to), first_layer);
  return grid;
}

}  // namespace kappamu::forward
