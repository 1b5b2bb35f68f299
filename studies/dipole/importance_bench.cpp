#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/processor_time.h"
#include "core/random.h"
#include "forward/dipole/direct/direct_sum.h"
#include "forward/dipole/local/local_sum.h"
#include "forward/dipole/transmitted.h"
#include "studies/dipole/dipole_bench.h"
#include "studies/objects/object_case.h"

namespace kappamu::studies {

namespace {

using namespace forward;
using namespace forward::dipole;

/// Kinds of samples, as shares of all.
struct Method {
  const char* name;
  double importance, light;  ///< the rest is uniform
  bool image_space = false;
};
constexpr std::array<Method, 6> methods{
    {{"uniform", 0.0, 0.0},
     {"importance", 1.0, 0.0},
     {"1/2 importance, 1/2 light", 0.5, 0.5},
     {"7/8 importance, 1/8 uniform", 0.875, 0.0},
     {"7/8 importance, 1/8 light", 0.875, 0.125},
     {"7/8 importance, 1/8 light, image space", 0.875, 0.125, true}}};

/// A scene with its exact sums at some triangles that the eye sees.
struct Scene {
  Scene(const ObjectCase& c, std::size_t receivers, const Request& request, Progress& progress)
      : name(c.name),
        bench(make_object_bench(c, "scenes/meshes", {}, progress)),
        profile(make_profile("dipole", {bench.kappa_mm, bench.mu_per_mm},
                             bench.object().boundary.eta)) {
    const Surface& surface = bench.object().surface;
    irradiance = transmitted(surface, bench.object().boundary.eta, bench.lights.front());
    eye = Eigen::Vector3d(1.0, 0.5, 2.0) *
          (3.0 * bounding_box(bench.object().mesh).sizes().maxCoeff());
    seen = seen_from(bench.problem(), eye);
    for (std::uint64_t i = 0; to.size() < receivers; ++i) {
      const auto t = static_cast<std::size_t>(uniform(key_of({request.seed, i})) *
                                              static_cast<double>(surface.size()));
      if (seen[t]) to.push_back(t);
    }
    exact = direct_sum(bench.object().mesh, surface, profile, Placement::rotated, irradiance, to);
  }

  std::string name;
  ObjectBench bench;
  Profile profile;
  Eigen::Vector3d eye;
  std::vector<double> irradiance, exact;
  std::vector<bool> seen;
  std::vector<std::size_t> to;
};

/// Relative 2-norm of what the eye does not see.
double missed(const Scene& scene) {
  std::vector<double> part = scene.irradiance;
  for (std::size_t t = 0; t < part.size(); ++t) {
    if (!scene.seen[t]) part[t] = 0.0;
  }
  const std::vector<double> of_part =
      direct_sum(scene.bench.object().mesh, scene.bench.object().surface, scene.profile,
                 Placement::rotated, part, scene.to);
  double squares = 0.0, size = 0.0;
  for (std::size_t i = 0; i < of_part.size(); ++i) {
    squares += std::pow(of_part[i] - scene.exact[i], 2);
    size += scene.exact[i] * scene.exact[i];
  }
  return std::sqrt(squares / size);
}

Json row_of(const Scene& scene, const Method& method, int samples, std::uint64_t repetitions,
            std::uint64_t seed) {
  const int importance = static_cast<int>(std::lround(method.importance * samples));
  const int light = static_cast<int>(std::lround(method.light * samples));
  const SampleCounts counts{importance, light, samples - importance - light};
  const ObjectProblem problem = scene.bench.problem();
  const LocalSum sum(problem, scene.profile, scene.irradiance);
  double squares = 0.0, size = 0.0;
  const double start = processor_seconds();
  for (std::size_t i = 0; i < scene.to.size(); ++i) {
    for (std::uint64_t k = 0; k < repetitions; ++k) {
      const std::uint64_t key = key_of({seed, i, k});
      const double value = method.image_space
                               ? sum.exitance_seen(scene.to[i], counts, key, scene.eye)
                               : sum.exitance(scene.to[i], counts, key);
      squares += std::pow(value - scene.exact[i], 2);
      size += scene.exact[i] * scene.exact[i];
    }
  }
  const double spent = processor_seconds() - start;
  const auto estimates = static_cast<double>(scene.to.size() * repetitions);
  return {{"scene", scene.name},
          {"method", method.name},
          {"samples", samples},
          {"error", std::sqrt(squares / size)},
          {"microseconds", 1e6 * spent / estimates}};
}

}  // namespace

void dipole_importance(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  using enum CaseLight;
  std::vector<ObjectCase> cases{{"sphere-skin1-80", "sphere", "skin1", 80.0, aslant, {}}};
  if (!quick) {
    cases.push_back({"nefertiti-skin1-150", "nefertiti", "skin1", 150.0, aslant, {}});
    cases.push_back({"nefertiti-skin2-72-side", "nefertiti", "skin2", 72.0, side, {}});
    cases.push_back({"slab-marble-24-below", "slab", "marble", 24.0, below, {}});
  }
  const std::size_t receivers = quick ? 8 : 64;
  const std::uint64_t repetitions = quick ? 1 : 8;
  Json rows = Json::array(), scenes = Json::array();
  for (const ObjectCase& c : cases) {
    progress.update("bench dipole", 0.5, c.name);
    const Scene scene(c, receivers, request, progress);
    scenes.push_back({{"scene", c.name},
                      {"triangles", scene.irradiance.size()},
                      {"missed_in_image_space", missed(scene)}});
    for (const Method& method : methods) {
      for (int samples = 8; samples <= (quick ? 32 : 2048); samples *= 4) {
        rows.push_back(row_of(scene, method, samples, repetitions, request.seed));
      }
    }
    save({{"receivers", receivers},
          {"repetitions", repetitions},
          {"scenes", scenes},
          {"rows", rows}});
  }
}

}  // namespace kappamu::studies
