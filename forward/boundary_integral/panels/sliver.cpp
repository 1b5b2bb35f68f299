#include "forward/boundary_integral/panels/sliver.h"

#include <algorithm>
#include <string>

#include "core/error.h"

namespace kappamu::forward::boundary_integral {

void refuse_slivers(const TriangleMesh& mesh) {
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
