// Iterations of model `embedded` on jagged, thin and mixed objects.
#include <cmath>
#include <random>

#include "core/mesh/shapes.h"
#include "studies/limits/cut_trial.h"
#include "studies/limits/limits.h"

namespace kappamu::studies {

namespace {

struct ObjectTrial {
  std::string name;
  TriangleMesh mesh;
  ObjectMedium medium;
};

ObjectMedium milky() {
  return ObjectMedium(Coefficients{0.3, 0.001});
}

/// Voxels of 1.25 mm, κ log-uniform over the contrast.
ObjectMedium random_medium(double contrast, std::uint64_t seed) {
  const GridShape shape{16, 16, 16, 1.25};
  auto volume = std::make_shared<Medium>(Medium{Volume<double>(shape), Volume<double>(shape)});
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (std::size_t k = 0; k < shape.cells(); ++k) {
    volume->kappa[k] = 0.3 * std::pow(contrast, uniform(generator));
    volume->mu[k] = 0.02 * (0.5 + uniform(generator));
  }
  return ObjectMedium(volume, Eigen::Affine3d::Identity(), Wrap::mirror);
}

/// So that no face lies along faces of cubes.
TriangleMesh tilted(TriangleMesh mesh) {
  const Eigen::AngleAxisd by(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex = by * vertex;
  return mesh;
}

std::vector<ObjectTrial> object_trials(std::uint64_t seed) {
  std::vector<ObjectTrial> trials;
  for (const std::string name : {"nefertiti", "spot", "bob"}) {
    trials.push_back({name, trial_mesh("scenes/meshes/" + name + ".ply"), milky()});
  }
  const std::filesystem::path dragon = "../shared/data/meshes/dragon.obj";
  if (std::filesystem::exists(dragon)) {
    trials.push_back({"dragon (narrow slits)", trial_mesh(dragon), milky()});
  }
  for (const int contrast : {100, 10'000}) {
    trials.push_back({"sphere, random κ, contrast " + std::to_string(contrast),
                      sphere_mesh(10.0, 64), random_medium(contrast, seed)});
  }
  for (const double thickness : {1.0, 0.1, 0.01, 0.001}) {
    trials.push_back({"sheet, " + Json(thickness).dump() + " mm",
                      tilted(box_mesh({20.0, 20.0, thickness}, 8)), milky()});
  }
  for (const double radius : {1.0, 0.1, 0.01}) {
    trials.push_back({"spike, radius " + Json(radius).dump() + " mm",
                      tilted(cone_mesh(radius, 20.0, 64)), milky()});
  }
  return trials;
}

}  // namespace

Json limit_objects(const Request& request, Progress& progress) {
  std::vector<int> levels{6, 7, 8, 9};
  if (request.size == Size::small) levels = {6, 7};
  if (request.size == Size::quick) levels = {4};
  Json rows = Json::array();
  for (const ObjectTrial& object : object_trials(request.seed)) {
    for (const int level : levels) {
      progress.update("objects", 0.0, object.name);
      const CutTrial trial = run_cut_trial(object.mesh, {object.medium}, level, request.device);
      rows.push_back({{"object", object.name},
                      {"equivalent", std::to_string(1 << level) + "³"},
                      {"cubes", trial.cubes},
                      {"smallest volume fraction", trial.smallest_fraction},
                      {"iterations", trial.iterations},
                      {"ended", trial.converged ? "converged" : "stopped"}});
    }
  }
  return rows;
}

}  // namespace kappamu::studies
