#include "forward/choice/machine_costs.h"

#include <algorithm>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "core/processor_time.h"
#include "forward/registry.h"

namespace kappamu::forward {

namespace {

constexpr double kappa_mm = 0.152, mu_per_mm = 0.0021, eta = 1.5;  // marble, red
constexpr double mean_free_paths = 24.0;
constexpr int tessellation = 64;
constexpr double probe_tolerance = 0.03;
constexpr double probe_photons = 20'000;

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

std::map<std::string, ProbeTime> probe_times(const RayCaster& rays, const std::string& device,
                                             int repetitions, Progress& progress) {
  const TriangleMesh mesh = probe_mesh();
  const Surface surface = surface_of(mesh);
  const ObjectMedium medium({kappa_mm, mu_per_mm});
  const std::vector<ObjectLight> lights{parallel_light(surface)};
  const ObjectProblem problem{mesh, surface, rays, medium, eta, lights};
  ObjectOptions options;
  options.device = device;
  options.tolerance = probe_tolerance;
  std::map<std::string, ProbeTime> times;
  for (const ModelDescription& model : object_models()) {
    if (model.measured == nullptr) continue;
    const std::string& name = model.name;
    OptionValues parameters;
    if (model.can.transport) parameters["photons"] = probe_photons;
    try {
      for (int repetition = 0; repetition < repetitions; ++repetition) {
        const double processor = processor_seconds();
        const Stopwatch wall;
        make_object_model(name, ModelError::warned, parameters)->solve(problem, options, progress);
        const ProbeTime time{wall.seconds(), processor_seconds() - processor};
        const auto [entry, fresh] = times.try_emplace(name, time);
        if (fresh) continue;
        entry->second = {std::min(entry->second.wall, time.wall),
                         std::min(entry->second.processor, time.processor)};
      }
    } catch (const InputError& refusal) {
      progress.warn("model " + name + " is not measured: " + refusal.what());
    }
  }
  return times;
}

MachineCosts machine_costs(const std::map<std::string, ProbeTime>& times) {
  MachineCosts costs;
  for (const auto& [name, time] : times) {
    const MeasuredModel* model = object_model(name).measured;
    if (model != nullptr && model->probe_seconds > 0.0)
      costs.emplace(name, time.wall / model->probe_seconds);
  }
  return costs;
}

}  // namespace kappamu::forward
