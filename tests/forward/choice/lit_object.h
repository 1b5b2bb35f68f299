// A mesh in parallel light, for the tests of forward/choice.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "forward/object_model.h"
#include "tests/forward/embedded/embedded_test_tools.h"

namespace kappamu::forward {

struct Lit {
  Lit(TriangleMesh its_mesh, const ObjectMedium& filling)
      : mesh(std::move(its_mesh)),
        surface(surface_of(mesh)),
        rays(embedded::make_caster(mesh)),
        medium(filling),
        lights(1) {
    const Eigen::Vector3d direction = Eigen::Vector3d(-1.0, -2.0, -3.0).normalized();
    for (std::size_t t = 0; t < surface.size(); ++t) {
      const double cosine = -direction.dot(surface.normal[t]);
      if (cosine <= 0.0) continue;
      lights[0].beams.push_back(
          {static_cast<int>(t), surface.position[t], direction, cosine * surface.area[t]});
    }
  }
  ObjectProblem problem() const { return {mesh, surface, *rays, medium, 1.3, lights}; }

  TriangleMesh mesh;
  Surface surface;
  std::unique_ptr<RayCaster> rays;
  ObjectMedium medium;
  std::vector<ObjectLight> lights;
};

}  // namespace kappamu::forward
