#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/mesh/surface_norm.h"
#include "forward/embedded/embedded_model.h"
#include "render/embree_caster.h"
#include "studies/objects/object_bench.h"
#include "studies/objects/object_measurement.h"

namespace kappamu::studies {

namespace {

using namespace forward;

/// No power of two, so that roundings differ.
constexpr double scaling = 3.0;

ObjectResult solved(const ObjectProblem& problem, const ObjectOptions& options) {
  Progress quiet;
  return EmbeddedModel().solve(problem, options, quiet);
}

/// Means of a mesh's values over the triangles of another mesh of the same object: each triangle
/// counts where its middle lies. Triangles without any keep what they have in `otherwise`.
std::vector<double> carried_over(const ObjectProblem& from, const std::vector<double>& values,
                                 const ObjectProblem& to, const std::vector<double>& otherwise) {
  std::vector<double> sum(to.surface.size(), 0.0), area(to.surface.size(), 0.0);
  const double off = 1e-3 * bounding_box(to.mesh).sizes().maxCoeff();
  for (std::size_t t = 0; t < from.surface.size(); ++t) {
    const Eigen::Vector3d& normal = from.surface.normal[t];
    const auto hit = to.rays.first_hit(from.surface.position[t] + off * normal, -normal, 0.0);
    if (!hit) continue;
    const auto here = static_cast<std::size_t>(hit->triangle);
    sum[here] += from.surface.area[t] * values[t];
    area[here] += from.surface.area[t];
  }
  for (std::size_t t = 0; t < sum.size(); ++t) {
    sum[t] = area[t] > 0.0 ? sum[t] / area[t] : otherwise[t];
  }
  return sum;
}

/// Relative 2-norm of what another mesh of the object changes, over the coarser one's triangles.
double changed(const ObjectProblem& fine, const std::vector<double>& on_fine,
               const ObjectProblem& coarse, const std::vector<double>& on_coarse) {
  return surface_difference(coarse.surface, carried_over(fine, on_fine, coarse, on_coarse),
                            on_coarse) /
         surface_norm(coarse.surface, on_coarse);
}

/// Whose facets are another body where they are of another size.
bool is_round(const std::string& shape) {
  return shape == "sphere" || shape == "torus" || shape == "cylinder";
}

/// The same with lengths, κ and 1/μ so many times as large.
ObjectResult solved_at_scale(const ObjectProblem& problem, const ObjectOptions& options) {
  TriangleMesh mesh = problem.mesh;
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= scaling;
  const Surface surface = surface_of(mesh);
  const auto rays = render::make_embree_caster(mesh);
  const Coefficients was = problem.medium.largest();
  const ObjectMedium medium(Coefficients{scaling * was.kappa, was.mu / scaling});
  std::vector<ObjectLight> lights = problem.lights;
  for (ObjectLight& light : lights) {
    for (Beam& beam : light.beams) {
      beam.position *= scaling;
      beam.power *= scaling * scaling;
    }
  }
  return solved({mesh, surface, *rays, medium, problem.eta, lights}, options);
}

}  // namespace

void measure_invariance(const Request& request, Progress& progress, const Save& save) {
  const ObjectSettings settings = object_settings(request);
  std::vector<std::string> wanted = request.words("scenes");
  if (wanted.empty()) {
    wanted = {"sphere-marble-24",    "cube-marble-24", "torus-skin2-24", "spot-marble-24",
              "nefertiti-marble-24", "bob-skin2-24",   "spot-block-24"};
    if (request.size != Size::full) wanted = {"sphere-marble-8-sky"};
  }
  std::vector<ObjectCase> cases = object_cases(Population::tuning, wanted);
  for (const ObjectCase& own : cases_of_files(request.words("mesh"))) cases.push_back(own);
  ObjectOptions options;
  options.device = request.device;
  options.tolerance = request.number("tolerance", request.size == Size::full ? 0.003 : 0.05);
  Json rows = Json::array();
  for (const ObjectCase& object : cases) {
    const int edges = settings.edges_per_size;
    const auto at = [&](int edges_per_size, std::optional<int> facets) {
      return make_object_bench(object, settings.meshes, settings.volume, progress, edges_per_size,
                               facets);
    };
    const auto add = [&](const std::string& change, const ObjectProblem& problem,
                         const ObjectResult& result, double difference) {
      rows.push_back({{"name", object.name},
                      {"change", change},
                      {"triangles", problem.surface.size()},
                      {"elements", result.elements},
                      {"error_estimate", result.error_estimate.front()},
                      {"difference", difference}});
      save({{"tolerance", options.tolerance}, {"rows", rows}});
    };
    progress.update("invariance", 0.0, object.name);
    const auto compare = [&](const ObjectProblem& problem, const ObjectResult& result, bool body) {
      const auto facets = [&](int at_edges) { return body ? at_edges : edges / 2; };
      const std::string kind = body ? "facets" : "edges";
      {
        const ObjectBench other = at(edges / 2, facets(edges / 2));
        const ObjectProblem coarse = other.problem();
        const ObjectResult found = solved(coarse, options);
        add(kind + " doubled", coarse, found,
            changed(problem, result.exitance, coarse, found.exitance));
      }
      const ObjectBench other = at(2 * edges, facets(2 * edges));
      const ObjectProblem fine = other.problem();
      const ObjectResult found = solved(fine, options);
      add(kind + " halved", fine, found, changed(fine, found.exitance, problem, result.exitance));
    };
    {
      const ObjectBench bench = at(edges, edges / 2);
      const ObjectProblem problem = bench.problem();
      const ObjectResult result = solved(problem, options);
      add("none", problem, result, 0.0);
      compare(problem, result, false);
      if (problem.medium.homogeneous()) {
        const ObjectResult found = solved_at_scale(problem, options);
        add("lengths, κ and 1/μ times 3", problem, found,
            surface_difference(problem.surface, found.exitance, result.exitance) /
                surface_norm(problem.surface, result.exitance));
      }
    }
    if (!is_round(object.shape)) continue;
    const ObjectBench bench = at(edges, edges);
    const ObjectProblem problem = bench.problem();
    const ObjectResult result = solved(problem, options);
    add("none, facets as edges", problem, result, 0.0);
    compare(problem, result, true);
  }
}

}  // namespace kappamu::studies
