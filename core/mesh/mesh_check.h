// Whether triangles bound a body, and what can be mended of meshes that nearly do.
//
// In this order: exactly equal vertices become one, without a word (files repeat them for normals
// and texture coordinates, STL for each triangle), as do those of open edges within 1e-6 of the
// box; triangles with fewer than three vertices, repeated and of no area (below 1e-12 of the box's
// longest edge squared) are dropped, those on an edge's line by turning that edge; orientation is
// made consistent, outwards on bodies and inwards on voids (a component within an odd number of
// others). All else is refused.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

/// Beyond these a mesh is refused before the work: reading and checking need 450 bytes a triangle.
inline constexpr std::size_t most_triangles = 2'000'000;
inline constexpr int most_components = 1000;
/// Share of the surface that may lie inside the body, or outside it, by self-intersections.
inline constexpr double most_hidden_surface = 1e-3;

/// Closed, oriented outwards, without triangles of zero area; no vertex is unused.
struct CheckedMesh {
  TriangleMesh mesh;
  std::vector<int> source;     ///< per triangle, its number in the mesh as it was given, from 0
  std::vector<int> component;  ///< per triangle, the piece it belongs to, from 0
  int components = 0;          ///< surfaces that share no edge: bodies and voids
  std::vector<std::string> mended;    ///< sentences: what was changed
  std::vector<std::string> warnings;  ///< sentences: what is left as it is, and may matter
};

/// What sentences call a triangle of the mesh as it was given: "triangle 7", or the place in a file
/// that it comes from.
using TriangleName = std::function<std::string(int)>;
std::string numbered_triangle(int triangle);

/// `name` begins every sentence; places are in the mesh's own unit and frame.
/// Throws InputError for a mesh that cannot be mended: an index that is no vertex, a coordinate
/// that is no number, no extent, a hole, an edge of three triangles, one side only (Möbius),
/// two components that intersect or share a part of their surfaces, self-intersection that hides
/// more of the surface than `most_hidden_surface`, or more triangles or components than the limits.
CheckedMesh check_mesh(const TriangleMesh& mesh, const std::string& name,
                       const TriangleName& triangle_name = numbered_triangle);

}  // namespace kappamu
