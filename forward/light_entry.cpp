#include "forward/light_entry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/error.h"
#include "core/mesh/edges.h"
#include "core/numbers/coefficient_bounds.h"
#include "core/random.h"

namespace kappamu::forward {

namespace {

void require(bool holds, const std::string& sentence) {
  if (!holds) throw InputError(sentence);
}

/// Whether every edge is run through as often one way as the other, by a sum of hashes.
bool balanced(const TriangleMesh& mesh) {
  std::uint64_t sum = 0;
  for (const Triangle& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto from = static_cast<std::uint32_t>(triangle[k]);
      const auto to = static_cast<std::uint32_t>(triangle[(k + 1) % 3]);
      const std::uint64_t edge = mix(std::uint64_t{std::min(from, to)} << 32 | std::max(from, to));
      sum += from < to ? edge : 0 - edge;
    }
  }
  return sum == 0;
}

/// Every edge must be run through as often one way as the other: else the mesh is open or a
/// triangle is flipped.
void check_closed(const TriangleMesh& mesh) {
  if (balanced(mesh)) return;
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
}

}  // namespace

double diffuse_transmittance(const BoundaryConstants& constants) {
  return constants.eta * constants.eta * (1.0 - constants.r_phi);
}

void check_problem(const ObjectProblem& problem, const ObjectOptions& options) {
  require(!problem.mesh.triangles.empty(), "the mesh has no triangles; give a closed mesh");
  for (std::size_t v = 0; v < problem.mesh.vertices.size(); ++v) {
    require(problem.mesh.vertices[v].allFinite(),
            "vertex " + std::to_string(v) + " of the mesh is not finite; mend the mesh file");
  }
  require(problem.surface.size() == problem.mesh.triangles.size(),
          "the surface has " + std::to_string(problem.surface.size()) + " samples but the mesh " +
              std::to_string(problem.mesh.triangles.size()) + " triangles");
  require(bounding_box(problem.mesh).sizes().maxCoeff() > 0.0,
          "the mesh has no extent; give a closed mesh");
  require(enclosed_volume(problem.mesh) > 0.0,
          "the mesh encloses no volume; its triangles must be counter-clockwise seen from outside");
  check_closed(problem.mesh);
  require(options.tolerance > 0.0 && options.tolerance < 1.0,
          "the tolerance must lie between 0 and 1");
  const Coefficients least = problem.medium.smallest(), most = problem.medium.largest();
  require(least.kappa >= least_kappa && most.kappa <= most_coefficient,
          "kappa must be positive, from 1e-9 to 1e9 mm");
  require(least.mu >= 0.0 && most.mu <= most_coefficient,
          "mu must be finite and not negative, at most 1e9 /mm");
  for (std::size_t l = 0; l < problem.lights.size(); ++l) {
    const ObjectLight& light = problem.lights[l];
    require(light.diffuse.empty() || light.diffuse.size() == problem.surface.size(),
            "light " + std::to_string(l) + " has " + std::to_string(light.diffuse.size()) +
                " irradiances for " + std::to_string(problem.surface.size()) + " surface samples");
    for (const Beam& beam : light.beams) {
      require(beam.triangle >= 0 && beam.triangle < static_cast<int>(problem.surface.size()),
              "a beam of light " + std::to_string(l) + " names triangle " +
                  std::to_string(beam.triangle) + ", which the mesh does not have");
    }
  }
}

}  // namespace kappamu::forward
