// Edges of a triangle mesh, and what neighbours across them settle: orientation and components.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

using Triangle = std::array<int, 3>;

/// One side of a triangle.
struct Edge {
  int low = 0, high = 0;  ///< its vertices
  int triangle = 0;
  bool rises = false;  ///< the triangle runs along it from `low` to `high`
};

/// Three for each triangle, sorted: the sides that share an edge lie beside each other.
std::vector<Edge> edges_of(const std::vector<Triangle>& triangles);

/// Calls act(begin, end) for the sides of every edge.
template <class Act>
void for_each_edge(const std::vector<Edge>& edges, const Act& act) {
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].low == edges[begin].low &&
           edges[end].high == edges[begin].high) {
      ++end;
    }
    act(begin, end);
  }
}

struct Orientation {
  std::vector<bool> turned;    ///< per triangle: to be turned, so that all of its component agree
  std::vector<int> component;  ///< per triangle
  int components = 0;
  std::optional<Edge> one_sided;  ///< an edge whose two triangles cannot agree
};
/// Components are joined by edges of two triangles; a component faces as its first triangle does.
Orientation oriented_alike(const std::vector<Triangle>& triangles);

/// An edge along which some component's triangles do not run as often up as down, if there is one.
std::optional<Edge> unbalanced_edge(const std::vector<Triangle>& triangles,
                                    const std::vector<int>& component);

/// Of each `flat` triangle (no area, its vertices on a line) the longest edge, shared with a
/// neighbour that is not flat, becomes the other diagonal of the two. Returns how many were
/// treated; those whose neighbour was treated wait for the next call.
std::size_t turn_caps(TriangleMesh& mesh, const std::vector<bool>& flat);

}  // namespace kappamu
