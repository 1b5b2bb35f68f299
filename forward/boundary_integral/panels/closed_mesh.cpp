#include "forward/boundary_integral/panels/closed_mesh.h"

#include <algorithm>
#include <string>

#include "core/error.h"
#include "core/mesh/edges.h"

namespace kappamu::forward::boundary_integral {

void check_closed(const TriangleMesh& mesh) {
  const std::vector<Edge> edges = edges_of(mesh.triangles);
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    const auto rises = std::count_if(edges.begin() + static_cast<std::ptrdiff_t>(begin),
                                     edges.begin() + static_cast<std::ptrdiff_t>(end),
                                     [](const Edge& edge) { return edge.rises; });
    const auto sides = static_cast<std::ptrdiff_t>(end - begin);
    if (2 * rises == sides) return;
    const std::string triangle = "triangle " + std::to_string(edges[begin].triangle);
    throw InputError(sides % 2 == 1
                         ? "the mesh is open at an edge of " + triangle + "; close it there"
                         : triangle +
                               " of the mesh and its neighbour face opposite ways; turn one of "
                               "them");
  });
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto vertex = [&](std::size_t k) {
      return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k % 3])];
    };
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::max(longest, (vertex(k + 1) - vertex(k)).squaredNorm());
    }
    const double doubled = (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0)).norm();
    if (doubled < thinnest_triangle * longest) {
      throw InputError("triangle " + std::to_string(t) +
                       " of the mesh is a sliver, its height below 1e-4 of its longest edge; "
                       "remesh it or use model embedded");
    }
  }
}

}  // namespace kappamu::forward::boundary_integral
