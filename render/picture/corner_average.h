// What is known per triangle, made continuous for pictures: a value per corner, the mean over the
// triangles round its vertex by their area. Triangles across a crease do not join the mean, so that
// edges of a box stay edges.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/parallel.h"

namespace kappamu::render {

class CornerAverage {
 public:
  /// Keeps references to both. Normals further apart than `crease_deg` make a crease.
  CornerAverage(const TriangleMesh& mesh, const Surface& surface, double crease_deg = 40.0);

  /// Three values per triangle, from `value(triangle)`.
  template <class T, class Value>
  std::vector<std::array<T, 3>> of(const T& zero, const Value& value) const {
    std::vector<std::array<T, 3>> corners(mesh_.triangles.size(), {zero, zero, zero});
    for_ranges(mesh_.triangles.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) average(t, value, corners[t]);
    });
    return corners;
  }

 private:
  template <class T, class Value>
  void average(std::size_t t, const Value& value, std::array<T, 3>& corner) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(mesh_.triangles[t][k]);
      double area = 0.0;
      for (std::size_t i = first_[vertex]; i < first_[vertex + 1]; ++i) {
        const std::size_t other = around_[i];
        if (other != t && surface_.normal[other].dot(surface_.normal[t]) < crease_) continue;
        corner[k] += surface_.area[other] * value(other);
        area += surface_.area[other];
      }
      if (area > 0.0) corner[k] /= area;
    }
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
