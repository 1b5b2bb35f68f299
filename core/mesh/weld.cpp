#include "core/mesh/weld.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/mesh/edges.h"

namespace kappamu {

namespace {

using Eigen::Vector3d;

std::vector<int> each_itself(const TriangleMesh& mesh) {
  std::vector<int> into(mesh.vertices.size());
  std::iota(into.begin(), into.end(), 0);
  return into;
}

const Vector3d& vertex(const TriangleMesh& mesh, int v) {
  return mesh.vertices[static_cast<std::size_t>(v)];
}

int root(const std::vector<int>& into, int v) {
  while (into[static_cast<std::size_t>(v)] != v) v = into[static_cast<std::size_t>(v)];
  return v;
}

}  // namespace

std::vector<int> equal_vertices(const TriangleMesh& mesh) {
  std::vector<int> order = each_itself(mesh), into(order.size());
  const auto less = [&](int a, int b) {
    const Vector3d &p = vertex(mesh, a), &q = vertex(mesh, b);
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  };
  std::stable_sort(order.begin(), order.end(), less);
  int same = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || less(order[i - 1], order[i])) same = order[i];
    into[static_cast<std::size_t>(order[i])] = same;
  }
  return into;
}

std::vector<int> ends_of_needles(const TriangleMesh& mesh, double distance) {
  std::vector<int> into = each_itself(mesh);
  for (const Triangle& t : mesh.triangles) {
    const std::array<Vector3d, 3> p{vertex(mesh, t[0]), vertex(mesh, t[1]), vertex(mesh, t[2])};
    if ((p[1] - p[0]).cross(p[2] - p[0]).norm() >= 2.0 * distance * distance) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      if ((p[k] - p[(k + 1) % 3]).norm() > distance) continue;
      const int a = root(into, t[k]), b = root(into, t[(k + 1) % 3]);
      into[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  for (int& v : into) v = root(into, v);
  return into;
}

std::vector<int> gaps_of_edges(const TriangleMesh& mesh, double distance) {
  std::vector<int> open;
  const std::vector<Edge> edges = edges_of(mesh.triangles);
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin == 1) open.insert(open.end(), {edges[begin].low, edges[begin].high});
  });
  // By x, so that few others are near; a mesh with thousands of open edges at one x is refused as
  // open rather than searched for ever.
  constexpr std::size_t most_neighbours = 4096;
  const auto less = [&](int a, int b) {
    const double p = vertex(mesh, a).x(), q = vertex(mesh, b).x();
    return p < q || (p == q && a < b);
  };
  std::sort(open.begin(), open.end(), less);
  open.erase(std::unique(open.begin(), open.end()), open.end());
  std::vector<int> into = each_itself(mesh);
  for (std::size_t i = 0; i < open.size(); ++i) {
    for (std::size_t j = i; j-- > 0 && j + most_neighbours > i;) {
      const Vector3d apart = vertex(mesh, open[i]) - vertex(mesh, open[j]);
      if (apart.x() > distance) break;
      if (apart.norm() > distance) continue;
      into[static_cast<std::size_t>(open[i])] = into[static_cast<std::size_t>(open[j])];
      break;
    }
  }
  return into;
}

}  // namespace kappamu
