#include "bench/objects/object_bench.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>

#include "bench/objects/object_case.h"
#include "bench/objects/object_reference.h"
#include "bench/objects/patches.h"
#include "core/error.h"
#include "forward/analytic/validity.h"
#include "forward/object_models.h"
#include "io/npy.h"

namespace kappamu::bench {

namespace {

struct Settings {
  std::vector<std::string> models;
  std::filesystem::path meshes, volume, references;
  double tolerance = 0.0;
  std::uint64_t photons = 0, reference_photons = 0;
  bool maps = false;
};

std::string word(const Request& request, const std::string& name, const std::string& standard) {
  return request.has(name) ? request.words(name).front() : standard;
}

Settings settings_of(const Request& request) {
  const bool quick = request.size == Size::quick;
  Settings s;
  s.models = request.words("models");
  if (s.models.empty()) s.models = forward::object_model_names();
  s.meshes = word(request, "meshes", "scenes/meshes");
  s.volume = word(request, "volume", "bench/objects/volume");
  s.references = word(request, "references",
                      quick ? request.folder / "references" : "bench/objects/references");
  s.tolerance = request.number("tolerance", quick ? 0.1 : 0.01);
  s.photons = static_cast<std::uint64_t>(request.number("photons", quick ? 5e3 : 2e5));
  s.reference_photons =
      static_cast<std::uint64_t>(request.number("reference-photons", quick ? 2e4 : 2e6));
  s.maps = request.has("maps");
  return s;
}

std::vector<ObjectCase> cases_of(const Request& request) {
  std::vector<std::string> wanted = request.words("scenes");
  if (wanted.empty() && request.size == Size::quick) {
    wanted = {"sphere-marble-8-sky", "box-with-void-marble-8"};
  }
  if (wanted.empty() && request.size == Size::small) {
    wanted = {"sphere-marble-24", "cube-marble-24", "bob-marble-24", "bob-skin1-24"};
  }
  return object_cases(wanted);
}

/// The largest error that docs/validity.md measured for diffusion in a slab of the object's albedo
/// and thickness.
double validity_error(const ObjectBench& bench) {
  const forward::ValidityEstimate estimate =
      forward::diffusion_validity(bench.albedo, bench.thickness);
  double worst = 0.0;
  for (const auto& error : {estimate.reflected, estimate.transmitted, estimate.far_map}) {
    worst = std::max(worst, std::abs(error.value_or(0.0)));
  }
  return worst;
}

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

class CaseMeasurement {
 public:
  CaseMeasurement(const ObjectCase& object, const Settings& settings, const Request& request,
                  Progress& progress)
      : object_(object),
        settings_(settings),
        request_(request),
        progress_(progress),
        bench_(make_object_bench(object, settings.meshes, settings.volume, progress)),
        patches_(make_patches(bench_.object().surface, bounding_box(bench_.object().mesh),
                              patches_across)),
        reference_(reference()) {}

  Json row(const std::string& model) const {
    forward::ObjectOptions options;
    options.tolerance = settings_.tolerance;
    options.device = request_.device;
    options.photons = settings_.photons;
    options.seed = request_.seed + 1;  // the reference has walked the first
    Json row{{"name", object_.name}, {"model", model}};
    try {
      const auto maker = forward::make_object_model(model);
      const double cpu = cpu_seconds();
      const auto start = std::chrono::steady_clock::now();
      const forward::ObjectResult result = maker->solve(bench_.problem(), options, progress_);
      const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
      add(result, spent.count(), cpu_seconds() - cpu, row);
      if (settings_.maps) write_map(model, result);
    } catch (const InputError& refusal) {
      row["refused"] = refusal.what();
    }
    return row;
  }

 private:
  ObjectReference reference() const {
    const std::filesystem::path file = reference_file(settings_.references, object_);
    if (std::filesystem::exists(file)) return read_reference(object_, bench_, patches_, file);
    const ObjectReference made =
        measure_reference(bench_, patches_, settings_.reference_photons, request_.seed, progress_);
    write_reference(made, object_, bench_, patches_, file);
    return made;
  }

  void add(const forward::ObjectResult& result, double seconds, double cpu, Json& row) const {
    const double allowed = validity_error(bench_);
    const ObjectError error = error_against(
        reference_, patches_, patches_.mean(result.exitance, bench_.object().surface), allowed);
    const forward::ObjectBalance& balance = result.balance.front();
    row["triangles"] = bench_.object().surface.size();
    row["size_over_mean_free_path"] = object_.size;
    row["thickness_over_mean_free_path"] = bench_.thickness;
    row["albedo"] = bench_.albedo;
    row["error"] = error.two_norm;
    row["reference_error"] = error.reference_error;
    row["mean_difference"] = error.mean;
    row["mean_difference_of_noise"] = error.mean_of_noise;
    row["validity_error"] = allowed;
    row["outside"] = error.outside;
    row["error_estimate"] = result.error_estimate.front();
    row["seconds"] = seconds;
    row["cpu_seconds"] = cpu;
    row["elements"] = result.elements;
    row["iterations"] = result.iterations;
    row["balance"] =
        (balance.exiting + balance.absorbed + balance.unscattered) / balance.entering - 1.0;
    if (object_.sky && object_.shape == "sphere") row["exact_error"] = exact_error(result);
    row["converged"] = result.converged;
    row["warnings"] = result.warnings;
  }

  double exact_error(const forward::ObjectResult& result) const {
    const Surface& surface = bench_.object().surface;
    const double radius = 0.5 * bounding_box(bench_.object().mesh).sizes().maxCoeff();
    const double exact = exitance_of_lit_sphere(radius, bench_.kappa_mm, bench_.mu_per_mm,
                                                bench_.object().boundary.eta);
    double error = 0.0, area = 0.0;
    for (std::size_t i = 0; i < surface.size(); ++i) {
      error += surface.area[i] * std::pow(result.exitance[i] / exact - 1.0, 2);
      area += surface.area[i];
    }
    return std::sqrt(error / area);
  }

  /// float32 [triangle][12]: corners [mm]; exitance, its mean over the patch, the reference's.
  void write_map(const std::string& model, const forward::ObjectResult& result) const {
    const TriangleMesh& mesh = bench_.object().mesh;
    const std::vector<double> means = patches_.mean(result.exitance, bench_.object().surface);
    std::vector<float> values;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const int v : mesh.triangles[t]) {
        for (int axis = 0; axis < 3; ++axis) {
          values.push_back(static_cast<float>(mesh.vertices[static_cast<std::size_t>(v)][axis]));
        }
      }
      values.push_back(static_cast<float>(result.exitance[t]));
      const auto patch = static_cast<std::size_t>(patches_.of_sample[t]);
      values.push_back(static_cast<float>(means[patch]));
      values.push_back(static_cast<float>(reference_.exitance[patch]));
    }
    io::write_npy(request_.folder / ("objects-map-" + object_.name + "-" + model + ".npy"),
                  {mesh.triangles.size(), 12}, values);
  }

  const ObjectCase& object_;
  const Settings& settings_;
  const Request& request_;
  Progress& progress_;
  ObjectBench bench_;
  Patches patches_;
  ObjectReference reference_;
};

void measure(const Request& request, Progress& progress, const Save& save) {
  const Settings settings = settings_of(request);
  const std::vector<ObjectCase> cases = cases_of(request);
  for (const std::string& model : settings.models) forward::make_object_model(model);
  Json rows = Json::array();
  for (const ObjectCase& object : cases) {
    const CaseMeasurement measurement(object, settings, request, progress);
    for (const std::string& model : settings.models) {
      rows.push_back(measurement.row(model));
      save({{"tolerance", settings.tolerance}, {"photons", settings.photons}, {"rows", rows}});
    }
  }
}

/// One object for each scene and model.
Json rows_of(const std::vector<Json>& records, const std::filesystem::path& /*folder*/) {
  return records.at(0).at("rows");
}

}  // namespace

double exitance_of_lit_sphere(double radius_mm, double kappa_mm, double mu_per_mm, double eta) {
  const BoundaryConstants constants = boundary_constants(eta);
  const double decay = std::sqrt(mu_per_mm / kappa_mm), x = decay * radius_mm;
  const double i0 = std::sinh(x) / x, slope = (std::cosh(x) - i0) / x;
  const double entering = eta * eta * (1.0 - constants.r_phi);
  const double q = 4.0 * entering / (1.0 - constants.r_phi);
  const double phi = q * i0 / (i0 + 2.0 * constants.A * kappa_mm * decay * slope);
  return (phi - q) / (2.0 * constants.A) + entering;
}

Subject objects_subject() {
  return {
      "objects",
      "Error and time of every model of objects, against Monte Carlo on the same scenes",
      "  kappamu bench objects -o out/bench                           all, half an hour\n"
      "  kappamu bench objects -o out/bench --scenes bob --models embedded\n"
      "  kappamu bench objects -o out/bench --quick                   two toy scenes, seconds\n\n"
      "Scenes are <shape>-<material>-<size>: named shapes and the meshes of scenes/meshes, the "
      "red\n"
      "channel of published materials or a measured block, the box's longest edge over the mean\n"
      "free path, under parallel light from aslant; -sky is even diffuse light instead.\n\n"
      "error: relative 2-norm over the surface of the difference from Monte Carlo in patches of\n"
      "1/8 of the object, what the reference's noise adds taken off; reference_error: that noise.\n"
      "mean_difference: mean of |difference| over the mean exitance, noise included, which alone\n"
      "would make it mean_difference_of_noise. validity_error: largest error of diffusion that\n"
      "docs/validity.md has for a slab of this albedo and of thickness 2V/S; outside: share of "
      "the\n"
      "surface where the difference exceeds it by more than three standard errors. exact_error:\n"
      "against the closed form of diffusion. balance: power out over power in, less 1. A model "
      "that\n"
      "refuses a scene has its sentence in the row instead.\n\n"
      "References are read from bench/objects/references in the working directory; one that is\n"
      "missing is measured, minutes, and recorded there.\n\n"
      "Do not trust seconds on a machine that does anything else; cpu_seconds (all threads "
      "together)\n"
      "suffer less.",
      {{"objects", "all", measure}},
      {{"scenes", "Those whose names begin so; all if absent", Setting::Kind::words},
       {"models", "Those named; all if absent", Setting::Kind::words},
       {"tolerance", "Error that models aim at (default 0.01)", Setting::Kind::number, 1e-6, 0.9},
       {"photons", "Of the model montecarlo (default 200000)", Setting::Kind::number, 2, 2e9},
       {"reference-photons", "Of references to be measured (default 2000000)",
        Setting::Kind::number, 2, 2e9},
       {"references", "Folder of recorded references (default bench/objects/references)",
        Setting::Kind::words},
       {"meshes", "Folder of meshes (default scenes/meshes)", Setting::Kind::words},
       {"volume", "The measured block (default bench/objects/volume)", Setting::Kind::words},
       {"maps", "Also write exitance per triangle, objects-map-<scene>-<model>.npy",
        Setting::Kind::flag}},
      rows_of};
}

}  // namespace kappamu::bench
