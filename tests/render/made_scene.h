// Scenes and answers that the tests of render share.
#pragma once

#include <functional>

#include "core/optics.h"
#include "forward/object_model.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// A milky sphere of 20 mm at the origin, seen from +z, without lights.
inline Scene sphere_scene() {
  Scene scene;
  scene.file = "test.json";
  SceneObject sphere;
  sphere.name = "ball";
  sphere.shape = std::string("sphere");
  sphere.size_mm = 20.0;
  HomogeneousMaterial material;
  material.kappa_mm = {0.2, 0.15, 0.1};
  material.mu_per_mm = {0.001, 0.002, 0.01};
  sphere.material = material;
  sphere.finish = {1.3, 0.0};
  scene.objects.push_back(sphere);
  scene.camera = {{0.0, 0.0, 100.0}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY(), 20.0};
  scene.film = {24, 24, 16, std::nullopt};
  return scene;
}

/// Exitance as a function of the problem, light and sample: what a test knows instead of a solve.
/// Its balance lets out what leaves and counts the rest as absorbed.
class KnownAnswer : public forward::ObjectModel {
 public:
  using Exitance =
      std::function<double(const forward::ObjectProblem&, std::size_t light, std::size_t sample)>;
  explicit KnownAnswer(Exitance exitance) : exitance_(std::move(exitance)) {}

  forward::ObjectResult solve(const forward::ObjectProblem& problem,
                              const forward::ObjectOptions& /*options*/,
                              Progress& /*progress*/) override {
    ++solves;
    lights += problem.lights.size();
    forward::ObjectResult result;
    const double diffuse_share =
        problem.eta * problem.eta * (1.0 - boundary_constants(problem.eta).r_phi);
    for (std::size_t i = 0; i < problem.lights.size(); ++i) {
      const forward::ObjectLight& light = problem.lights[i];
      forward::ObjectBalance balance;
      for (const forward::Beam& beam : light.beams) {
        const double cosine =
            -beam.direction.dot(problem.surface.normal[static_cast<std::size_t>(beam.triangle)]);
        balance.entering += beam.power * (1.0 - fresnel_external(problem.eta, cosine));
      }
      for (std::size_t t = 0; t < problem.surface.size(); ++t) {
        result.exitance.push_back(exitance_(problem, i, t));
        balance.exiting += result.exitance.back() * problem.surface.area[t];
        if (!light.diffuse.empty()) {
          balance.entering += diffuse_share * light.diffuse[t] * problem.surface.area[t];
        }
      }
      balance.absorbed = balance.entering - balance.exiting;
      result.balance.push_back(balance);
      result.error_estimate.push_back(0.0);
    }
    result.converged = true;
    result.message = "known";
    return result;
  }

  std::size_t solves = 0, lights = 0;  ///< counted over all calls

 private:
  Exitance exitance_;
};

}  // namespace kappamu::render
