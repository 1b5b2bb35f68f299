#include "forward/embedded/geometry/cut_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "core/parallel.h"

namespace kappamu::forward::embedded {

namespace {

/// Below this share of a cube, rounding could turn the volume negative: the surface alone counts.
constexpr double smallest_fraction = 1e-13;

/// Whether a point off the surface is inside, by the majority of three rays.
bool inside(const Eigen::Vector3d& point_mm, const TriangleMesh& mesh, const RayCaster& rays) {
  static const std::array<Eigen::Vector3d, 3> directions{
      Eigen::Vector3d(0.5477, 0.3111, 0.7767).normalized(),
      Eigen::Vector3d(-0.2718, 0.8141, -0.5131).normalized(),
      Eigen::Vector3d(0.1618, -0.7320, 0.6616).normalized()};
  int votes = 0;
  for (const Eigen::Vector3d& direction : directions) {
    const std::optional<RayHit> hit = rays.first_hit(point_mm, direction);
    if (!hit) continue;
    const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(hit->triangle)];
    const Eigen::Vector3d& p = mesh.vertices[static_cast<std::size_t>(a)];
    const Eigen::Vector3d normal = (mesh.vertices[static_cast<std::size_t>(b)] - p)
                                       .cross(mesh.vertices[static_cast<std::size_t>(c)] - p);
    if (normal.dot(direction) > 0.0) ++votes;
  }
  return votes >= 2;
}

int root_of(std::vector<int>& parent, int k) {
  while (parent[static_cast<std::size_t>(k)] != k) {
    parent[static_cast<std::size_t>(k)] =
        parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(k)])];
    k = parent[static_cast<std::size_t>(k)];
  }
  return k;
}

Eigen::Vector3d point_in(const Cube& cube, double share) {
  const double edge = std::ldexp(1.0, -cube.level);
  return edge * Eigen::Vector3d(cube.at[0] + share, cube.at[1] + share, cube.at[2] + share);
}

/// For every leaf that is not cut by the surface: whether it is inside. Leaves that share part of a
/// face lie in one region, and one ray decides for the region.
std::vector<char> regions_inside(const Octree& tree, const std::vector<int>& leaves,
                                 const std::vector<char>& cut, const TriangleMesh& mesh,
                                 const RayCaster& rays) {
  std::vector<int> place(leaves.empty() ? 0 : tree.node_count(), -1);
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    place[static_cast<std::size_t>(leaves[k])] = static_cast<int>(k);
  }
  std::vector<int> parent(leaves.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    if (cut[k] != 0) continue;
    const Cube& cube = tree.cube(leaves[k]);
    for (int side = 0; side < 6; ++side) {
      std::array<std::int64_t, 3> at{cube.at[0], cube.at[1], cube.at[2]};
      at[static_cast<std::size_t>(side / 2)] += side % 2 == 0 ? 1 : -1;
      const int node = tree.containing(cube.level, at);
      if (node < 0 || !tree.is_leaf(node)) continue;  // smaller neighbours ask from their side
      const int other = place[static_cast<std::size_t>(node)];
      if (cut[static_cast<std::size_t>(other)] != 0) continue;
      parent[static_cast<std::size_t>(root_of(parent, static_cast<int>(k)))] =
          root_of(parent, other);
    }
  }
  std::vector<char> state(leaves.size(), 0);
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    if (cut[k] == 0 && parent[k] == static_cast<int>(k)) {
      state[k] = inside(tree.to_mm(point_in(tree.cube(leaves[k]), 0.5)), mesh, rays) ? 1 : 0;
    }
  }
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    if (cut[k] == 0)
      state[k] = state[static_cast<std::size_t>(root_of(parent, static_cast<int>(k)))];
  }
  return state;
}

}  // namespace

std::vector<int> object_leaves(const Octree& tree, const TriangleMesh& mesh,
                               const RayCaster& rays) {
  const std::vector<int> leaves = tree.leaves();
  std::vector<char> cut;
  for (const int leaf : leaves) cut.push_back(tree.meets_surface(leaf) ? 1 : 0);
  const std::vector<char> whole_inside = regions_inside(tree, leaves, cut, mesh, rays);
  std::vector<int> result;
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    if (cut[k] != 0 || whole_inside[k] != 0) result.push_back(leaves[k]);
  }
  return result;
}

CutMesh cut_mesh(const Octree& tree, const TriangleMesh& mesh, const RayCaster& rays) {
  const std::vector<int> leaves = tree.leaves();
  std::vector<std::unique_ptr<CutCell>> cells(leaves.size());
  std::vector<char> cut(leaves.size(), 0);
  constexpr std::size_t chunk = 512;
  for_rows(static_cast<int>((leaves.size() + chunk - 1) / chunk), [&](int row) {
    const std::size_t begin = static_cast<std::size_t>(row) * chunk;
    for (std::size_t k = begin; k < std::min(leaves.size(), begin + chunk); ++k) {
      if (!tree.meets_surface(leaves[k])) continue;
      const Cube& cube = tree.cube(leaves[k]);
      const Eigen::Vector3d at(cube.at[0], cube.at[1], cube.at[2]);
      auto cell = std::make_unique<CutCell>();
      tree.for_triangles(leaves[k], [&](int index, const Triangle& triangle) {
        Triangle local;
        for (std::size_t i = 0; i < 3; ++i)
          local[i] = std::ldexp(1.0, cube.level) * triangle[i] - at;
        cell->add(index, local);
      });
      if (cell->pieces().empty()) continue;
      cells[k] = std::move(cell);
      cut[k] = 1;
    }
  });
  const std::vector<char> whole_inside = regions_inside(tree, leaves, cut, mesh, rays);

  CutMesh result;
  result.edge_mm = tree.edge_mm();
  result.cube_of_leaf.assign(tree.node_count(), -1);
  for (std::size_t k = 0; k < leaves.size(); ++k) {
    if (!cells[k] && whole_inside[k] == 0) continue;
    const int cube = static_cast<int>(result.cubes.size());
    result.cube_of_leaf[static_cast<std::size_t>(leaves[k])] = cube;
    result.cubes.push_back(tree.cube(leaves[k]));
    result.leaf.push_back(leaves[k]);
    result.cut.push_back(cells[k] ? static_cast<int>(result.volume.size()) : -1);
    if (!cells[k]) continue;
    std::optional<Corner> corner = cells[k]->corner();
    if (!corner) {
      const Eigen::Vector3d at = tree.to_mm(point_in(result.cubes.back(), 1.0));
      corner = inside(at, mesh, rays) ? Corner::inside : Corner::outside;
    }
    Moments volume = cells[k]->volume(*corner);
    if (volume[0] < smallest_fraction) volume.fill(0.0);
    result.volume.push_back(volume);
    result.surface.push_back(cells[k]->surface());
    const double face = result.h(result.cubes.size() - 1) * result.h(result.cubes.size() - 1);
    for (const SurfacePiece& piece : cells[k]->pieces()) {
      CutMesh::Piece scaled{piece.triangle, cube, {}};
      for (std::size_t i = 0; i < 8; ++i) {
        scaled.weight[i] = static_cast<float>(face * piece.weight[i]);
      }
      result.pieces.push_back(scaled);
    }
    cells[k].reset();
  }
  return result;
}

}  // namespace kappamu::forward::embedded
