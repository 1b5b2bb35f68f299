#include "bench/objects/object_case.h"

#include <algorithm>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "io/volume/volume_file.h"
#include "render/light/incident_light.h"
#include "render/scene/published_materials.h"

namespace kappamu::bench {

namespace {

constexpr const char* measured_block = "block";
const std::vector<std::string> meshes_shipped{"spot", "bob", "nefertiti"};
const std::vector<std::string> procedural{"sphere", "slab",          "cube",      "cylinder",
                                          "torus",  "box-with-void", "split-cube"};

bool is_shipped(const std::string& shape) {
  return std::count(meshes_shipped.begin(), meshes_shipped.end(), shape) > 0;
}

std::string name_of_case(const ObjectCase& c) {
  std::string material = c.material;
  std::replace(material.begin(), material.end(), ' ', '-');
  return c.shape + "-" + material + "-" + std::to_string(std::lround(c.size)) +
         (c.sky ? "-sky" : "");
}

std::vector<ObjectCase> all_cases() {
  std::vector<std::string> shapes = procedural;
  shapes.insert(shapes.end(), meshes_shipped.begin(), meshes_shipped.end());
  std::vector<ObjectCase> cases;
  for (const std::string& shape : shapes) {
    const auto add = [&](const char* material, const std::vector<double>& sizes, bool sky = false) {
      for (const double size : sizes) cases.push_back({"", shape, material, size, sky});
    };
    add("marble", {8.0, 24.0, 72.0});
    add("skin2", {24.0, 72.0});
    add("skin1", {24.0});
    if (shape == "sphere") add("marble", {8.0, 24.0, 72.0}, true);
    if (shape == "sphere" || is_shipped(shape)) add(measured_block, {24.0, 72.0});
  }
  for (ObjectCase& c : cases) c.name = name_of_case(c);
  return cases;
}

/// Means over the red channel of a volume file.
Coefficients mean_of_volume(const std::filesystem::path& file) {
  const io::VolumeSet set = io::read_volume(io::find_volume(file));
  const Medium& medium = set.media.front();
  double extinction = 0.0, mu = 0.0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    extinction += 1.0 / medium.kappa[i];
    mu += medium.mu[i];
  }
  const auto n = static_cast<double>(medium.kappa.size());
  return {n / extinction, mu / n};
}

}  // namespace

std::vector<ObjectCase> object_cases(const std::vector<std::string>& wanted) {
  std::vector<ObjectCase> cases = all_cases();
  if (wanted.empty()) return cases;
  for (const std::string& name : wanted) {
    if (std::none_of(cases.begin(), cases.end(),
                     [&](const ObjectCase& c) { return c.name.starts_with(name); })) {
      throw InputError("--scenes: no scene's name begins with '" + name +
                       "'; scenes are named <shape>-<material>-<size>, such as " + cases[0].name);
    }
  }
  std::erase_if(cases, [&](const ObjectCase& c) {
    return std::none_of(wanted.begin(), wanted.end(),
                        [&](const std::string& name) { return c.name.starts_with(name); });
  });
  return cases;
}

forward::ObjectProblem ObjectBench::problem() const {
  return {object().mesh,         object().surface,
          *object().rays,        *object().media.channels[0],
          object().boundary.eta, lights};
}

ObjectBench make_object_bench(const ObjectCase& c, const std::filesystem::path& meshes,
                              const std::filesystem::path& volume, Progress& progress) {
  ObjectBench bench;
  render::SceneObject object;
  object.name = c.name;
  if (is_shipped(c.shape)) {
    object.shape = meshes / (c.shape + ".ply");
  } else {
    object.shape = c.shape;
  }
  if (c.material == measured_block) {
    const Coefficients mean = mean_of_volume(volume);
    bench.kappa_mm = mean.kappa;
    bench.mu_per_mm = mean.mu;
    render::VolumeMaterial material;
    material.volume = volume;
    object.material = material;
  } else {
    render::HomogeneousMaterial material = render::published_material(c.material);
    bench.kappa_mm = material.kappa_mm[0];
    bench.mu_per_mm = material.mu_per_mm[0];
    material.kappa_mm = render::Colour::Constant(bench.kappa_mm);
    material.mu_per_mm = render::Colour::Constant(bench.mu_per_mm);
    object.material = material;
  }
  const double mean_free_path = 3.0 * bench.kappa_mm;
  bench.albedo = 1.0 - bench.mu_per_mm * mean_free_path;
  const double size_mm = c.size * mean_free_path;
  object.size_mm = size_mm;

  render::Scene scene;
  scene.file = c.name;
  scene.objects.push_back(object);
  scene.camera.position_mm = {0.0, 0.0, 10.0 * size_mm};
  if (c.sky) {
    render::EnvironmentLight sky;
    sky.radiance = render::Colour::Constant(1.0 / EIGEN_PI);
    scene.lights.emplace_back(sky);
  } else {
    render::DirectionalLight sun;
    sun.direction = Eigen::Vector3d(-3.0, -5.0, -8.0).normalized();
    scene.lights.emplace_back(sun);
  }
  std::vector<std::string> warnings;
  bench.world = std::make_unique<render::World>(scene, warnings);
  const auto environment = render::make_environment(scene.lights);
  constexpr std::uint64_t seed = 1;  // the light is part of the scene, not of a run
  render::IncidentLight light =
      render::incident_light(*bench.world, 0, render::make_light_sources(scene.lights),
                             environment ? &*environment : nullptr, seed, progress);
  bench.power = light.power[0];
  bench.lights.push_back(std::move(light.channels[0]));

  double area = 0.0;
  for (const double a : bench.object().surface.area) area += a;
  bench.thickness = 2.0 * enclosed_volume(bench.object().mesh) / area / mean_free_path;
  return bench;
}

}  // namespace kappamu::bench
