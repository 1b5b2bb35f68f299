#include "render/picture/corner_average.h"

#include <cmath>
#include <numbers>

namespace kappamu::render {

CornerAverage::CornerAverage(const TriangleMesh& mesh, const Surface& surface, double crease_deg)
    : mesh_(mesh),
      surface_(surface),
      crease_(std::cos(crease_deg * std::numbers::pi / 180.0)),
      first_(mesh.vertices.size() + 1, 0),
      around_(3 * mesh.triangles.size()) {
  for (const auto& triangle : mesh.triangles) {
    for (const int vertex : triangle) ++first_[static_cast<std::size_t>(vertex) + 1];
  }
  for (std::size_t vertex = 1; vertex < first_.size(); ++vertex)
    first_[vertex] += first_[vertex - 1];
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const int vertex : mesh.triangles[t])
      around_[next[static_cast<std::size_t>(vertex)]++] = t;
  }
}

}  // namespace kappamu::render
