#include "forward/choice/machine_costs.h"

#include <algorithm>
#include <chrono>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "forward/choice/model_table.h"
#include "forward/object_models.h"

namespace kappamu::forward {

namespace {

constexpr double kappa_mm = 0.152, mu_per_mm = 0.0021, eta = 1.5;  // marble, red
constexpr double mean_free_paths = 24.0;
constexpr int tessellation = 10;
constexpr double tolerance = 0.03;
constexpr std::uint64_t photons = 20'000;

ObjectLight parallel_light(const Surface& surface) {
  const Eigen::Vector3d direction = Eigen::Vector3d(-3.0, -5.0, -8.0).normalized();
  ObjectLight light;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const double cosine = -direction.dot(surface.normal[t]);
    if (cosine <= 0.0) continue;
    light.beams.push_back(
        {static_cast<int>(t), surface.position[t], direction, cosine * surface.area[t]});
  }
  return light;
}

}  // namespace

TriangleMesh probe_mesh() {
  return make_shape("cube", 3.0 * kappa_mm * mean_free_paths, tessellation);
}

MachineCosts probe_seconds(const RayCaster& rays, const std::string& device, int repetitions,
                           Progress& progress) {
  const TriangleMesh mesh = probe_mesh();
  const Surface surface = surface_of(mesh);
  const ObjectMedium medium({kappa_mm, mu_per_mm});
  const std::vector<ObjectLight> lights{parallel_light(surface)};
  const ObjectProblem problem{mesh, surface, rays, medium, eta, lights};
  ObjectOptions options;
  options.device = device;
  options.tolerance = tolerance;
  options.photons = photons;
  MachineCosts seconds;
  for (const MeasuredModel& model : measured_models()) {
    const std::string name(model.name);
    try {
      for (int repetition = 0; repetition < repetitions; ++repetition) {
        const auto start = std::chrono::steady_clock::now();
        make_object_model(name)->solve(problem, options, progress);
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
        const auto [entry, fresh] = seconds.try_emplace(name, spent.count());
        if (!fresh) entry->second = std::min(entry->second, spent.count());
      }
    } catch (const InputError& refusal) {
      progress.warn("model " + name + " is not measured: " + refusal.what());
    }
  }
  return seconds;
}

MachineCosts machine_costs(const MachineCosts& seconds) {
  MachineCosts costs;
  for (const MeasuredModel& model : measured_models()) {
    const auto found = seconds.find(std::string(model.name));
    if (found != seconds.end() && model.probe_seconds > 0.0) {
      costs.emplace(found->first, found->second / model.probe_seconds);
    }
  }
  return costs;
}

}  // namespace kappamu::forward
