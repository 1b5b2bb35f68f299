#include "core/mesh/mesh_refine.h"

#include <map>
#include <utility>

#include "core/error.h"

namespace kappamu {

namespace {

using Triangle = std::array<int, 3>;
/// Of edges longer than allowed, by their ends: the vertex in the middle.
using Halves = std::map<std::pair<int, int>, int>;

std::pair<int, int> edge(int a, int b) {
  return {std::min(a, b), std::max(a, b)};
}

Halves halve_long_edges(TriangleMesh& mesh, double longest_edge) {
  Halves halves;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = edge(t[k], t[(k + 1) % 3]);
      const Eigen::Vector3d& p = mesh.vertices[static_cast<std::size_t>(a)];
      const Eigen::Vector3d& q = mesh.vertices[static_cast<std::size_t>(b)];
      if ((p - q).norm() <= longest_edge) continue;
      const auto [half, is_new] =
          halves.try_emplace({a, b}, static_cast<int>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(0.5 * (p + q));
    }
  }
  return halves;
}

/// The parts of a triangle whose edges are halved where `half` is not negative; half[k] lies
/// between corners k and k + 1. Corners may be vertices or anything else that stands for them.
void split(const Triangle& t, const std::array<int, 3>& half, std::vector<Triangle>& parts) {
  int count = 0, first = 0;
  for (int k = 0; k < 3; ++k) {
    if (half[static_cast<std::size_t>(k)] >= 0) ++count;
  }
  // Turned so that the cases below start at a halved edge (two: the unhalved edge comes last).
  for (int k = 0; k < 3; ++k) {
    const bool here = half[static_cast<std::size_t>(k)] >= 0;
    const bool before = half[static_cast<std::size_t>((k + 2) % 3)] >= 0;
    if (here && (count != 2 || !before)) first = k;
  }
  const auto corner = [&](int k) { return t[static_cast<std::size_t>((first + k) % 3)]; };
  const auto middle = [&](int k) { return half[static_cast<std::size_t>((first + k) % 3)]; };
  if (count == 0) {
    parts.push_back(t);
  } else if (count == 1) {
    parts.push_back({corner(0), middle(0), corner(2)});
    parts.push_back({middle(0), corner(1), corner(2)});
  } else if (count == 2) {
    parts.push_back({middle(0), corner(1), middle(1)});
    parts.push_back({corner(0), middle(0), middle(1)});
    parts.push_back({corner(0), middle(1), corner(2)});
  } else {
    parts.push_back({corner(0), middle(0), middle(2)});
    parts.push_back({middle(0), corner(1), middle(1)});
    parts.push_back({middle(2), middle(1), corner(2)});
    parts.push_back({middle(0), middle(1), middle(2)});
  }
}

/// The same parts in texture coordinates, which are linear over the triangle.
void split_texture(const CornerTexture& corners, const std::array<int, 3>& half,
                   std::vector<CornerTexture>& parts) {
  std::array<Eigen::Vector2f, 6> places{corners[0], corners[1], corners[2]};
  std::array<int, 3> middle{-1, -1, -1};
  for (std::size_t k = 0; k < 3; ++k) {
    places[3 + k] = 0.5F * (corners[k] + corners[(k + 1) % 3]);
    if (half[k] >= 0) middle[k] = static_cast<int>(3 + k);
  }
  std::vector<Triangle> pieces;
  split({0, 1, 2}, middle, pieces);
  for (const Triangle& piece : pieces) {
    CornerTexture& part = parts.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) part[k] = places[static_cast<std::size_t>(piece[k])];
  }
}

}  // namespace

TriangleMesh refined(const TriangleMesh& mesh, double longest_edge, std::size_t limit) {
  TriangleMesh fine = mesh;
  while (true) {
    const Halves halves = halve_long_edges(fine, longest_edge);
    if (halves.empty()) return fine;
    std::vector<Triangle> parts;
    std::vector<CornerTexture> texture;
    for (std::size_t i = 0; i < fine.triangles.size(); ++i) {
      const Triangle& t = fine.triangles[i];
      std::array<int, 3> half{-1, -1, -1};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto found = halves.find(edge(t[k], t[(k + 1) % 3]));
        if (found != halves.end()) half[k] = found->second;
      }
      split(t, half, parts);
      if (!fine.texture.empty()) split_texture(fine.texture[i], half, texture);
    }
    if (parts.size() > limit) {
      throw InputError("the mesh needs more than " + std::to_string(limit) +
                       " triangles to have edges below " + std::to_string(longest_edge) +
                       " mm; its triangles are too long for their width, remesh it");
    }
    fine.triangles = std::move(parts);
    fine.texture = std::move(texture);
  }
}

}  // namespace kappamu
