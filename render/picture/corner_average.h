// What is known per triangle, made continuous for pictures: a value per corner, the mean over the
// triangles round its vertex by their area. Triangles across a crease do not join the mean, so that
// edges of a box stay edges.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/parallel.h"

namespace kappamu::render {

/// Corners of a mesh that meet in a vertex and whose means are over the same triangles, each such
/// set once.
struct SharedCorners {
  std::vector<std::array<std::uint32_t, 3>> of_triangle;  ///< numbers of its three
  std::vector<std::size_t> first;  ///< of each: 3 t + k, the first of the mesh's that it is
};

class CornerAverage {
 public:
  /// Keeps references to both. Normals further apart than `crease_deg` make a crease.
  CornerAverage(const TriangleMesh& mesh, const Surface& surface, double crease_deg = 40.0);

  /// Three values per triangle, from `value(triangle)`.
  template <class T, class Value>
  std::vector<std::array<T, 3>> of(const T& zero, const Value& value) const {
    std::vector<std::array<T, 3>> corners(mesh_.triangles.size(), {zero, zero, zero});
    for_ranges(mesh_.triangles.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        for (std::size_t k = 0; k < 3; ++k) average(t, k, value, corners[t][k]);
      }
    });
    return corners;
  }

  /// Of the surface as it is.
  SharedCorners shared() const;
  /// One value per shared corner.
  template <class T, class Value>
  std::vector<T> of(const SharedCorners& shared, const T& zero, const Value& value) const {
    std::vector<T> corners(shared.first.size(), zero);
    for_ranges(corners.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        average(shared.first[i] / 3, shared.first[i] % 3, value, corners[i]);
      }
    });
    return corners;
  }

 private:
  bool joined(std::size_t t, std::size_t other) const {
    return other == t || surface_.normal[other].dot(surface_.normal[t]) >= crease_;
  }

  template <class T, class Value>
  void average(std::size_t t, std::size_t k, const Value& value, T& corner) const {
    const auto vertex = static_cast<std::size_t>(mesh_.triangles[t][k]);
    double area = 0.0;
    for (std::size_t i = first_[vertex]; i < first_[vertex + 1]; ++i) {
      const std::size_t other = around_[i];
      if (!joined(t, other)) continue;
      corner += surface_.area[other] * value(other);
      area += surface_.area[other];
    }
    if (area > 0.0) corner /= area;
  }

  const TriangleMesh& mesh_;
  const Surface& surface_;
  double crease_;                    ///< cosine
  std::vector<std::size_t> first_;   ///< of each vertex in `around_`, and the end
  std::vector<std::size_t> around_;  ///< triangles round a vertex
};

/// At barycentric weights of the second and third corner.
template <class T>
T interpolated(const std::array<T, 3>& corners, double u, double v) {
  return (1.0 - u - v) * corners[0] + u * corners[1] + v * corners[2];
}

}  // namespace kappamu::render
