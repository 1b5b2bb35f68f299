#include "studies/objects/object_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "io/volume/volume_file.h"
#include "render/light/incident_light.h"
#include "render/material/published_materials.h"

namespace kappamu::studies {

namespace {

constexpr const char* measured_block = "block";
const std::vector<std::string> meshes_shipped{"spot", "bob", "nefertiti"};

/// A named shape at a proportion of its own, stretched to a box.
struct BenchShape {
  const char* name;
  const char* shape;
  std::optional<double> proportion;
  Eigen::Vector3d edges;  ///< of the box; none positive: the shape's own
};

const Eigen::Vector3d as_made = Eigen::Vector3d::Zero();
const std::vector<BenchShape> procedural{
    {"sphere", "sphere", {}, as_made},
    {"slab", "slab", {}, as_made},
    {"cube", "cube", {}, as_made},
    {"cylinder", "cylinder", {}, as_made},
    {"torus", "torus", {}, as_made},
    {"box-with-void", "box-with-void", {}, as_made},
    {"split-cube", "split-cube", {}, as_made},
    {"thin-slab", "slab", 0.1, as_made},
};
/// Of the validation population alone.
const std::vector<BenchShape> unseen{
    {"ellipsoid", "sphere", {}, {1.0, 0.6, 0.4}},
    {"brick", "cube", {}, {1.0, 0.5, 0.25}},
    {"drum", "cylinder", 0.9, as_made},
    {"cone", "spike", 0.6, as_made},
    {"plate", "slab", 0.06, as_made},
    {"ring", "torus", 0.5, as_made},
    {"hollow", "box-with-void", 0.7, as_made},
};

bool is_shipped(const std::string& shape) {
  return std::count(meshes_shipped.begin(), meshes_shipped.end(), shape) > 0;
}

struct BenchLight {
  const char* word;           ///< of the scene's name
  Eigen::Vector3d direction;  ///< of travel
};
const BenchLight& kind_of(CaseLight light) {
  static const std::array<BenchLight, 4> kinds{{{"", {-3.0, -5.0, -8.0}},
                                                {"-side", {10.0, -2.0, -1.0}},
                                                {"-below", {1.0, 8.0, 4.0}},
                                                {"-sky", as_made}}};
  return kinds[static_cast<std::size_t>(light)];
}

std::string name_of_case(const ObjectCase& c) {
  std::string material = c.material;
  std::replace(material.begin(), material.end(), ' ', '-');
  return c.shape + "-" + material + "-" + std::to_string(std::lround(c.size)) +
         kind_of(c.light).word;
}

std::vector<ObjectCase> tuning_cases() {
  std::vector<std::string> shapes;
  for (const BenchShape& shape : procedural) shapes.emplace_back(shape.name);
  shapes.pop_back();  // the thin slab: for [T] Table 5.1 alone
  shapes.insert(shapes.end(), meshes_shipped.begin(), meshes_shipped.end());
  std::vector<ObjectCase> cases;
  for (const std::string& shape : shapes) {
    const auto add = [&](const char* material, const std::vector<double>& sizes,
                         CaseLight light = CaseLight::aslant) {
      for (const double size : sizes) cases.push_back({"", shape, material, size, light, {}});
    };
    const bool round = shape == "sphere" || shape == "torus" || is_shipped(shape);
    add("marble", {8.0, 24.0, 72.0});
    add("skin2", {24.0});
    if (round) add("skin2", {72.0});
    add("skin1", {24.0});
    if (shape == "sphere" || shape == "cube" || shape == "torus" || shape == "bob")
      add("ketchup", {24.0});
    if (shape == "sphere") add("marble", {8.0, 24.0, 72.0}, CaseLight::sky);
    if (shape == "cube") add("marble", {72.0}, CaseLight::sky);
    if (shape == "sphere" || is_shipped(shape)) add(measured_block, {24.0});
    if (shape == "nefertiti") add(measured_block, {72.0});
  }
  cases.push_back({"", "thin-slab", "marble", 72.0, CaseLight::aslant, {}});
  return cases;
}

std::vector<ObjectCase> validation_cases() {
  using enum CaseLight;
  return {{"", "ellipsoid", "skim milk", 12.0, side, {}},
          {"", "ellipsoid", "apple", 40.0, below, {}},
          {"", "ellipsoid", "chicken1", 20.0, aslant, {}},
          {"", "ellipsoid", "potato", 20.0, sky, {}},
          {"", "ellipsoid", measured_block, 30.0, side, {}},
          {"", "brick", "potato", 16.0, side, {}},
          {"", "brick", "lowfat chocolate milk", 40.0, below, {}},
          {"", "brick", "skim milk", 12.0, aslant, {}},
          {"", "brick", "chicken1", 30.0, side, {}},
          {"", "brick", measured_block, 36.0, aslant, {}},
          {"", "drum", "apple", 20.0, below, {}},
          {"", "drum", "white grapefruit juice", 12.0, side, {}},
          {"", "drum", "potato", 50.0, aslant, {}},
          {"", "cone", "skim milk", 30.0, side, {}},
          {"", "cone", "lowfat chocolate milk", 15.0, below, {}},
          {"", "cone", measured_block, 40.0, below, {}},
          {"", "plate", "potato", 40.0, below, {}},
          {"", "plate", "apple", 80.0, side, {}},
          {"", "ring", "white grapefruit juice", 30.0, below, {}},
          {"", "ring", "potato", 60.0, side, {}},
          {"", "hollow", "apple", 30.0, side, {}},
          {"", "hollow", "lowfat chocolate milk", 60.0, below, {}},
          {"", "bob", "apple", 48.0, below, {}},
          {"", "bob", "lowfat chocolate milk", 30.0, sky, {}},
          {"", "spot", "chicken1", 36.0, side, {}},
          {"", "spot", "skim milk", 16.0, below, {}},
          {"", "nefertiti", "potato", 40.0, side, {}}};
}

std::vector<ObjectCase> named(std::vector<ObjectCase> cases) {
  for (ObjectCase& c : cases) c.name = name_of_case(c);
  return cases;
}

/// Keeps those whose names begin with one of `wanted`.
void keep_named(std::vector<ObjectCase>& cases, const std::vector<std::string>& wanted) {
  std::erase_if(cases, [&](const ObjectCase& c) {
    return std::none_of(wanted.begin(), wanted.end(),
                        [&](const std::string& name) { return c.name.starts_with(name); });
  });
}

/// The shape that a case names, `size_mm` long; files are in `meshes`.
void set_shape(const ObjectCase& c, double size_mm, const std::filesystem::path& meshes,
               render::SceneObject& object) {
  object.size_mm = size_mm;
  if (!c.file.empty()) {
    object.shape = c.file;
    return;
  }
  for (const auto* list : {&procedural, &unseen}) {
    for (const BenchShape& known : *list) {
      if (c.shape != known.name) continue;
      object.shape = std::string(known.shape);
      object.proportion = known.proportion;
      if (known.edges[0] > 0.0) object.size_mm = Eigen::Vector3d(size_mm * known.edges);
      return;
    }
  }
  object.shape = meshes / (c.shape + ".ply");
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

std::vector<ObjectCase> object_cases(Population population,
                                     const std::vector<std::string>& wanted) {
  const std::vector<ObjectCase> tuning = named(tuning_cases()), other = named(validation_cases());
  if (wanted.empty()) return population == Population::tuning ? tuning : other;
  std::vector<ObjectCase> cases = tuning;
  cases.insert(cases.end(), other.begin(), other.end());
  for (const std::string& name : wanted) {
    if (std::none_of(cases.begin(), cases.end(),
                     [&](const ObjectCase& c) { return c.name.starts_with(name); })) {
      throw InputError("--scenes: no scene's name begins with '" + name +
                       "'; scenes are named <shape>-<material>-<size>, such as " + cases[0].name);
    }
  }
  keep_named(cases, wanted);
  return cases;
}

std::vector<ObjectCase> drawn_cases(int count, std::uint64_t seed,
                                    const std::vector<std::string>& wanted) {
  std::vector<std::string> shapes = meshes_shipped, materials = render::published_material_names();
  for (const auto* list : {&procedural, &unseen}) {
    for (const BenchShape& shape : *list) shapes.emplace_back(shape.name);
  }
  // A quarter of the cases is heterogeneous.
  materials.insert(materials.end(), materials.size() / 3, measured_block);
  constexpr std::array lights{CaseLight::aslant, CaseLight::side, CaseLight::below, CaseLight::sky};
  constexpr double least = 10.0, most = 70.0;
  std::mt19937_64 random(seed);
  const auto one_of = [&](const auto& list) { return list[random() % list.size()]; };
  std::vector<ObjectCase> cases;
  while (static_cast<int>(cases.size()) < count) {
    const double part = static_cast<double>(random() % 1024) / 1024.0;
    ObjectCase drawn{"",
                     one_of(shapes),
                     one_of(materials),
                     std::round(least * std::pow(most / least, part)),
                     one_of(lights),
                     {}};
    drawn.name = name_of_case(drawn);
    const auto same = [&](const ObjectCase& c) { return c.name == drawn.name; };
    if (std::none_of(cases.begin(), cases.end(), same)) cases.push_back(drawn);
  }
  if (!wanted.empty()) keep_named(cases, wanted);
  return cases;
}

std::vector<ObjectCase> cases_of_files(const std::vector<std::string>& files) {
  std::vector<ObjectCase> cases;
  for (const std::string& file : files) {
    const std::string stem = std::filesystem::path(file).stem().string();
    for (const double size : {8.0, 24.0, 72.0}) {
      cases.push_back({"", stem, "marble", size, CaseLight::aslant, file});
    }
    cases.push_back({"", stem, "skin2", 24.0, CaseLight::aslant, file});
  }
  return named(std::move(cases));
}

forward::ObjectProblem ObjectBench::problem() const {
  return {object().mesh,         object().surface,
          *object().rays,        *object().media.channels[0],
          object().boundary.eta, lights};
}

ObjectBench make_object_bench(const ObjectCase& c, const std::filesystem::path& meshes,
                              const std::filesystem::path& volume, Progress& progress,
                              int edges_per_size, std::optional<int> facets_per_size) {
  ObjectBench bench;
  render::SceneObject object;
  object.name = c.name;
  object.edges_per_size = edges_per_size;
  object.facets_per_size = facets_per_size;
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
  set_shape(c, size_mm, meshes, object);

  render::Scene scene;
  scene.file = c.name;
  scene.objects.push_back(object);
  scene.camera.position_mm = {0.0, 0.0, 10.0 * size_mm};
  if (c.light == CaseLight::sky) {
    render::EnvironmentLight sky;
    sky.radiance = render::Colour::Constant(1.0 / EIGEN_PI);
    scene.lights.emplace_back(sky);
  } else {
    render::DirectionalLight sun;
    sun.direction = kind_of(c.light).direction.normalized();
    scene.lights.emplace_back(sun);
  }
  std::vector<std::string> warnings;
  bench.world = std::make_unique<render::World>(scene, warnings);
  const auto environment = render::make_environment(scene.lights);
  render::IncidentLight light =
      render::incident_light(*bench.world, 0, render::make_light_sources(scene.lights),
                             environment ? &*environment : nullptr, /*seed=*/1, progress);
  bench.power = light.power[0];
  bench.lights.push_back(std::move(light.channels[0]));

  double area = 0.0;
  for (const double a : bench.object().surface.area) area += a;
  bench.thickness = 2.0 * enclosed_volume(bench.object().mesh) / area / mean_free_path;
  return bench;
}

}  // namespace kappamu::studies
