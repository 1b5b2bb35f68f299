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

SharedCorners CornerAverage::shared() const {
  constexpr std::size_t most_triangles = 64;  // round a vertex: one bit of a word each
  SharedCorners shared;
  shared.of_triangle.resize(mesh_.triangles.size());
  std::vector<std::uint64_t> joins(3 * mesh_.triangles.size(), 0);
  for_ranges(mesh_.triangles.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t corner = 3 * begin; corner < 3 * end; ++corner) {
      const std::size_t t = corner / 3;
      const auto vertex = static_cast<std::size_t>(mesh_.triangles[t][corner % 3]);
      const std::size_t first = first_[vertex], last = first_[vertex + 1];
      if (last - first > most_triangles) continue;
      for (std::size_t i = first; i < last; ++i) {
        if (joined(t, around_[i])) joins[corner] |= std::uint64_t{1} << (i - first);
      }
    }
  });
  constexpr std::uint32_t none = ~std::uint32_t{0};
  std::vector<std::uint32_t> last_of_vertex(mesh_.vertices.size(), none), before;
  for (std::size_t corner = 0; corner < joins.size(); ++corner) {
    const auto vertex = static_cast<std::size_t>(mesh_.triangles[corner / 3][corner % 3]);
    std::uint32_t same = last_of_vertex[vertex];
    while (same != none && (joins[corner] == 0 || joins[shared.first[same]] != joins[corner])) {
      same = before[same];
    }
    if (same == none) {
      same = static_cast<std::uint32_t>(shared.first.size());
      shared.first.push_back(corner);
      before.push_back(last_of_vertex[vertex]);
      last_of_vertex[vertex] = same;
    }
    shared.of_triangle[corner / 3][corner % 3] = same;
  }
  return shared;
}

}  // namespace kappamu::render
