// Objects under simple lights, as every model of objects is asked to solve them.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "forward/registry.h"
#include "tests/forward/embedded/embedded_test_tools.h"

namespace kappamu::forward {

/// Diffuse light from above.
inline ObjectLight sky(const Surface& surface) {
  ObjectLight light;
  for (const Eigen::Vector3d& normal : surface.normal)
    light.diffuse.push_back(0.5 + 0.5 * normal.z());
  return light;
}

/// Beams of unit irradiance across them through the middles of triangles that face against
/// `direction`.
inline ObjectLight parallel_beams(const Surface& surface, const Eigen::Vector3d& direction) {
  ObjectLight light;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const double cosine = -surface.normal[t].dot(direction);
    if (cosine <= 1e-6) continue;
    light.beams.push_back(
        {static_cast<int>(t), surface.position[t], direction, cosine * surface.area[t]});
  }
  return light;
}

inline ObjectLight sky(const TriangleMesh& mesh) {
  return sky(surface_of(mesh));
}

/// From straight above.
inline ObjectLight sun(const TriangleMesh& mesh) {
  return parallel_beams(surface_of(mesh), -Eigen::Vector3d::UnitZ());
}

/// A model of that name; one that walks, or may, takes so many photons.
inline std::unique_ptr<ObjectModel> make_walking(const std::string& name, double photons) {
  const ModelDescription& model = object_model(name);
  if (!model.can.transport && !model.can.chooses) return make_object_model(name);
  return make_object_model(name, ModelError::warned, {{"photons", photons}});
}

struct LitObject {
  LitObject(TriangleMesh its_mesh, const ObjectMedium& filling, double its_eta = 1.3)
      : mesh(std::move(its_mesh)),
        surface(surface_of(mesh)),
        rays(embedded::make_caster(mesh)),
        medium(filling),
        eta(its_eta) {}

  ObjectProblem problem() const { return {mesh, surface, *rays, medium, eta, lights}; }

  TriangleMesh mesh;
  Surface surface;
  std::unique_ptr<RayCaster> rays;
  ObjectMedium medium;
  double eta;
  std::vector<ObjectLight> lights;
};

}  // namespace kappamu::forward
