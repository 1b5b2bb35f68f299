#include "forward/embedded/geometry/octree.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace kappamu::forward::embedded {

Octree::Octree(const TriangleMesh& mesh) {
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const double extent = box.sizes().maxCoeff();
  edge_mm_ = 1.0347 * extent;
  // Fractions of the margin left below the object.
  const Eigen::Vector3d below(0.4142135, 0.3819660, 0.4472136);
  origin_ = box.center() - Eigen::Vector3d::Constant(extent / 2.0) - (edge_mm_ - extent) * below;
  triangles_.reserve(mesh.triangles.size());
  Node root;
  root.count = mesh.triangles.size();
  for (const auto& corner : mesh.triangles) {
    Triangle triangle;
    for (std::size_t i = 0; i < 3; ++i) {
      triangle[i] = to_root(mesh.vertices[static_cast<std::size_t>(corner[i])]);
    }
    list_.push_back(static_cast<int>(triangles_.size()));
    triangles_.push_back(triangle);
  }
  nodes_.push_back(root);
}

void Octree::split(int node) {
  const int child = static_cast<int>(nodes_.size());
  nodes_[static_cast<std::size_t>(node)].child = child;
  const Node parent = nodes_[static_cast<std::size_t>(node)];
  check(parent.cube.level < deepest_level, "octree deeper than its coordinates");
  const double edge = std::ldexp(1.0, -parent.cube.level - 1);
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    Node part;
    part.cube.level = parent.cube.level + 1;
    part.parent = node;
    Eigen::Vector3d centre;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      part.cube.at[axis] = 2 * parent.cube.at[axis] + ((octant >> axis) & 1U);
      centre[axis] = (part.cube.at[axis] + 0.5) * edge;
    }
    part.first = list_.size();
    for (std::size_t k = parent.first; k < parent.first + parent.count; ++k) {
      const int triangle = list_[k];
      if (meets_cube(triangles_[static_cast<std::size_t>(triangle)], centre, edge / 2.0)) {
        list_.push_back(triangle);
      }
    }
    part.count = list_.size() - part.first;
    nodes_.push_back(part);
  }
}

void Octree::refine_surface(int level) {
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    if (nodes_[node].child < 0 && nodes_[node].count > 0 && nodes_[node].cube.level < level) {
      split(static_cast<int>(node));
    }
  }
  balance();
}

void Octree::refine_each(const std::vector<int>& nodes) {
  for (const int node : nodes) {
    if (is_leaf(node)) split(node);
  }
}

void Octree::refine(const std::vector<int>& nodes, const std::vector<int>& times) {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    std::vector<int> open{nodes[k]}, next;
    for (int left = times[k]; left > 0; --left) {
      for (const int node : open) {
        if (is_leaf(node)) split(node);
        for (int child = first_child(node); child < first_child(node) + 8; ++child) {
          if (meets_surface(child) || !meets_surface(node)) next.push_back(child);
        }
      }
      open.swap(next);
      next.clear();
    }
  }
  balance();
}

void Octree::balance() {
  // A split cube needs all its neighbours of the same size to exist. From the finest up, what this
  // splits is coarser than what asks for it.
  std::vector<std::vector<int>> split_at(deepest_level + 1);
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    if (nodes_[node].child >= 0) {
      split_at[static_cast<std::size_t>(nodes_[node].cube.level)].push_back(static_cast<int>(node));
    }
  }
  for (int level = deepest_level; level > 0; --level) {
    const std::vector<int>& here = split_at[static_cast<std::size_t>(level)];
    for (std::size_t k = 0; k < here.size(); ++k) {
      const Cube cube = this->cube(here[k]);
      for (int direction = 0; direction < 27; ++direction) {
        const std::array<std::int64_t, 3> at{
            static_cast<std::int64_t>(cube.at[0]) + direction % 3 - 1,
            static_cast<std::int64_t>(cube.at[1]) + direction / 3 % 3 - 1,
            static_cast<std::int64_t>(cube.at[2]) + direction / 9 - 1};
        int node = containing(level, at);
        while (node >= 0 && this->cube(node).level < level) {
          split_at[static_cast<std::size_t>(this->cube(node).level)].push_back(node);
          split(node);
          node = containing(level, at);
        }
      }
    }
  }
}

std::vector<int> Octree::leaves() const {
  std::vector<int> found, open{0};
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    const int child = first_child(node);
    if (child < 0) {
      found.push_back(node);
      continue;
    }
    for (int octant = 7; octant >= 0; --octant) open.push_back(child + octant);
  }
  return found;
}

int Octree::containing(int level, const std::array<std::int64_t, 3>& at) const {
  for (const std::int64_t a : at) {
    if (a < 0 || a >= (std::int64_t{1} << level)) return -1;
  }
  int node = 0;
  for (int below = level - 1; below >= 0; --below) {
    const int child = first_child(node);
    if (child < 0) break;
    node = child + static_cast<int>(((at[0] >> below) & 1) | (((at[1] >> below) & 1) << 1) |
                                    (((at[2] >> below) & 1) << 2));
  }
  return node;
}

int Octree::leaf_at(const Eigen::Vector3d& point, int near) const {
  std::array<std::uint32_t, 3> at;
  const double count = std::ldexp(1.0, deepest_level);
  for (int axis = 0; axis < 3; ++axis) {
    at[static_cast<std::size_t>(axis)] =
        static_cast<std::uint32_t>(std::clamp(point[axis] * count, 0.0, count - 1.0));
  }
  const auto holds = [&](const Cube& cube) {
    const int below = deepest_level - cube.level;
    return at[0] >> below == cube.at[0] && at[1] >> below == cube.at[1] &&
           at[2] >> below == cube.at[2];
  };
  int node = near;
  while (!holds(cube(node))) node = parent(node);
  for (int below = deepest_level - cube(node).level - 1; !is_leaf(node); --below) {
    node =
        first_child(node) + static_cast<int>((at[0] >> below & 1U) | (at[1] >> below & 1U) << 1U |
                                             (at[2] >> below & 1U) << 2U);
  }
  return node;
}

}  // namespace kappamu::forward::embedded
