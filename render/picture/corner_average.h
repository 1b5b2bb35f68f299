// What is known per triangle, made continuous for pictures: a value per corner, the mean over the
// triangles round its vertex by their area. Triangles across a crease do not join the mean, so that
// edges of a box stay edges.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu::render {

class CornerAverage {
 public:
  /// Keeps references to both. Normals further apart than `crease_deg` make a crease.
  CornerAverage(const TriangleMesh& mesh, const Surface& surface, double crease_deg = 40.0);

  /// Three values per triangle, from `value(triangle)`.
  template <class T, class Value>
  std::vector<std::array<T, 3>> of(const T& zero, const Value& value) const {
    std::vector<std::array<T, 3>> corners(mesh_.triangles.size(), {zero, zero, zero});
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto vertex = static_cast<std::size_t>(mesh_.triangles[t][k]);
        double area = 0.0;
        for (std::size_t i = first_[vertex]; i < first_[vertex + 1]; ++i) {
          const std::size_t other = around_[i];
          if (other != t && surface_.normal[other].dot(surface_.normal[t]) < crease_) continue;
          corners[t][k] += surface_.area[other] * value(other);
          area += surface_.area[other];
        }
        if (area > 0.0) corners[t][k] /= area;
      }
    }
    return corners;
  }

 private:
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
