#include "studies/limits/cut_trial.h"

#include <algorithm>

#include "forward/embedded/discretisation.h"
#include "forward/embedded/solver_choice.h"
#include "render/embree_caster.h"
#include "render/scene/object_shape.h"

namespace kappamu::studies {

namespace {

using namespace forward;
using namespace forward::embedded;

constexpr double eta = 1.3;
constexpr double tolerance = 1e-6;
constexpr int most_iterations = 100;

}  // namespace

CutTrial run_cut_trial(const TriangleMesh& mesh, const std::vector<ObjectMedium>& media, int level,
                       const std::string& device) {
  const auto rays = render::make_embree_caster(mesh);
  const Surface surface = surface_of(mesh);
  CutTrial trial;
  Octree tree(mesh);
  tree.refine_surface(level);
  CutMesh cut = cut_mesh(tree, mesh, *rays);
  std::vector<const ObjectMedium*> pointers;
  for (const ObjectMedium& medium : media) pointers.push_back(&medium);
  const Discretisation d(std::move(tree), std::move(cut), pointers, boundary_constants(eta).A);

  std::vector<double> flux;
  for (const Eigen::Vector3d& normal : surface.normal) flux.push_back(std::max(0.0, normal.z()));
  std::vector<Load> loads;
  for (std::size_t c = 0; c < media.size(); ++c) {
    loads.push_back({c, std::vector<double>(d.levels.unknowns(), 0.0)});
    add_surface_load(d.mesh, d.space(), flux, loads.back().power);
  }
  std::vector<std::vector<double>> fluence;
  const CgReport report = make_linear_solver(d.levels, loads.size(), device)
                              ->solve(loads, fluence, {tolerance, most_iterations});
  trial.cubes = d.mesh.cubes.size();
  trial.iterations = report.iterations;
  trial.converged = report.converged;
  for (std::size_t k = 0; k < d.mesh.cubes.size(); ++k) {
    const double fraction = d.mesh.fraction(k);
    if (fraction > 0.0) trial.smallest_fraction = std::min(trial.smallest_fraction, fraction);
  }
  return trial;
}

TriangleMesh trial_mesh(const std::filesystem::path& file) {
  render::SceneObject object;
  object.name = file.stem();
  object.shape = file;
  object.size_mm = 20.0;
  std::vector<std::string> warnings;
  return render::make_object_mesh(object, warnings);
}

}  // namespace kappamu::studies
