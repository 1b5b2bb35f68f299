#include "forward/choice/object_features.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "core/mesh/edges.h"
#include "forward/block/block_grid.h"
#include "forward/patches.h"

namespace kappamu::forward {

namespace {

constexpr double sharp_cosine = 0.766;  // of 40°, as pictures keep corners sharp from
constexpr int lattice = 16;
constexpr double most_edges = 3.0;

Coefficients mean_coefficients(const ObjectMedium& medium, const Eigen::AlignedBox3d& box) {
  if (medium.homogeneous()) return medium.smallest();
  double extinction = 0.0, mu = 0.0;
  for (int z = 0; z < lattice; ++z) {
    for (int y = 0; y < lattice; ++y) {
      for (int x = 0; x < lattice; ++x) {
        const Eigen::Array3d at = (Eigen::Array3d(x, y, z) + 0.5) / lattice;
        const Coefficients here = medium.at(box.min() + (at * box.sizes().array()).matrix());
        extinction += 1.0 / here.kappa;
        mu += here.mu;
      }
    }
  }
  constexpr double n = lattice * lattice * lattice;
  return {n / extinction, mu / n};
}

double area_of(const Surface& surface) {
  return std::accumulate(surface.area.begin(), surface.area.end(), 0.0);
}

/// Length of the edges whose two triangles turn by more than 40° [mm].
double sharp_length(const TriangleMesh& mesh, const Surface& surface) {
  double length = 0.0;
  const std::vector<Edge> edges = edges_of(mesh.triangles);
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2) return;
    const auto normal = [&](std::size_t side) -> const Eigen::Vector3d& {
      return surface.normal[static_cast<std::size_t>(edges[side].triangle)];
    };
    if (normal(begin).dot(normal(begin + 1)) >= sharp_cosine) return;
    const auto corner = [&](int vertex) -> const Eigen::Vector3d& {
      return mesh.vertices[static_cast<std::size_t>(vertex)];
    };
    length += (corner(edges[begin].low) - corner(edges[begin].high)).norm();
  });
  return length;
}

double contrast_of(const ObjectMedium& medium) {
  if (medium.homogeneous()) return 1.0;
  const Coefficients low = medium.smallest(), high = medium.largest();
  const double least_mu = std::max(low.mu, 1e-3 / (3.0 * high.kappa));  // less hardly absorbs
  return std::max(high.kappa / low.kappa, std::max(high.mu, least_mu) / least_mu);
}

void add_light(const ObjectProblem& problem, std::span<const ObjectLight> lights,
               ObjectFeatures& features) {
  double diffuse = 0.0, beams = 0.0, facing = 0.0;
  for (const ObjectLight& light : lights) {
    for (std::size_t i = 0; i < light.diffuse.size(); ++i)
      diffuse += light.diffuse[i] * problem.surface.area[i];
    for (const Beam& beam : light.beams) {
      beams += beam.power;
      const double along =
          beam.direction.dot(problem.surface.normal[static_cast<std::size_t>(beam.triangle)]);
      facing += beam.power * (along > 0.0 ? 1.0 : -along);  // from inside there is no slant
    }
  }
  if (diffuse + beams > 0.0) features.diffuse = diffuse / (diffuse + beams);
  if (beams > 0.0) features.slant = 1.0 - facing / beams;
}

}  // namespace

EquivalentSlab equivalent_slab(const ObjectProblem& problem) {
  const Coefficients mean = mean_coefficients(problem.medium, bounding_box(problem.mesh));
  const double mean_free_path = 3.0 * mean.kappa;
  return {2.0 * enclosed_volume(problem.mesh) / area_of(problem.surface) / mean_free_path,
          1.0 - mean.mu * mean_free_path, mean_free_path};
}

ObjectFeatures features_of(const ObjectProblem& problem, std::optional<std::size_t> light) {
  const EquivalentSlab slab = equivalent_slab(problem);
  const double mean_free_path = slab.mean_free_path;
  const double longest = bounding_box(problem.mesh).sizes().maxCoeff();
  const double area = area_of(problem.surface);
  ObjectFeatures features;
  features.size = longest / mean_free_path;
  features.thickness = slab.thickness;
  features.albedo = slab.albedo;
  features.edges = std::min(sharp_length(problem.mesh, problem.surface) * mean_free_path / area,
                            most_edges / features.size);
  features.patches =
      make_patches(problem.surface, bounding_box(problem.mesh), patches_across).size();
  features.contrast = contrast_of(problem.medium);
  features.block = block::block_grid(problem.mesh, problem.medium).has_value();
  const std::span<const ObjectLight> lights(problem.lights);
  add_light(problem, light ? lights.subspan(*light, 1) : lights, features);
  features.triangles = problem.surface.size();
  return features;
}

}  // namespace kappamu::forward
