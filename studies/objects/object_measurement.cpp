#include "studies/objects/object_measurement.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "forward/analytic/validity.h"
#include "forward/model_error.h"
#include "forward/registry.h"
#include "io/npy.h"
#include "studies/objects/object_bench.h"

namespace kappamu::studies {

namespace {

std::string word(const Request& request, const std::string& name, const std::string& standard) {
  return request.has(name) ? request.words(name).front() : standard;
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

}  // namespace

ObjectSettings object_settings(const Request& request) {
  const bool quick = request.size == Size::quick;
  ObjectSettings s;
  s.models = request.words("models");
  if (s.models.empty()) {
    // What local diffusion sums by samples dipole-rotated sums in a hundredth of the time.
    s.models = forward::object_model_names();
    std::erase(s.models, "local-diffusion");
  }
  s.meshes = word(request, "meshes", "scenes/meshes");
  s.volume = word(request, "volume", "studies/objects/volume");
  s.references = word(request, "references",
                      quick ? request.folder / "references" : "studies/objects/references");
  s.tolerance = request.number("tolerance", quick ? 0.1 : 0.01);
  s.photons = static_cast<std::uint64_t>(request.number("photons", quick ? 5e3 : 2e5));
  s.reference_photons =
      static_cast<std::uint64_t>(request.number("reference-photons", quick ? 2e4 : 2e6));
  s.edges_per_size = quick ? 12 : 64;
  s.maps = request.has("maps");
  return s;
}

void SpentTime::record(Json& row) const {
  row["cpu_seconds"] = processor_seconds() - processor_;
  row["seconds"] = watch_.seconds();
}

ObjectMeasurement::ObjectMeasurement(const ObjectCase& object, const ObjectSettings& settings,
                                     const Request& request, Progress& progress)
    : object_(object),
      settings_(settings),
      request_(request),
      progress_(progress),
      bench_(make_object_bench(object, settings.meshes, settings.volume, progress,
                               settings.edges_per_size)),
      patches_(forward::make_patches(bench_.object().surface, bounding_box(bench_.object().mesh),
                                     forward::patches_across)),
      reference_(reference()),
      features_(forward::features_of(bench_.problem())) {}

forward::ObjectOptions ObjectMeasurement::options() const {
  forward::ObjectOptions options;
  options.tolerance = settings_.tolerance;
  options.device = request_.device;
  options.seed = request_.seed + 1;  // the reference has walked the first
  return options;
}

std::unique_ptr<forward::ObjectModel> make_walking(const std::string& model,
                                                   std::uint64_t photons) {
  OptionValues parameters;
  if (forward::object_model(model).can.transport)
    parameters["photons"] = static_cast<double>(photons);
  return forward::make_object_model(model, forward::ModelError::warned, parameters);
}

Json ObjectMeasurement::row(const std::string& model, const forward::ObjectOptions& options,
                            std::uint64_t photons) const {
  Json row{{"name", object_.name}, {"model", model}, {"photons", photons}};
  try {
    const auto maker = make_walking(model, photons);
    SpentTime spent;
    const forward::ObjectResult result = maker->solve(bench_.problem(), options, progress_);
    spent.record(row);
    if (row.at("cpu_seconds") < brief_seconds) {
      Json again;
      spent = {};
      maker->solve(bench_.problem(), options, progress_);
      spent.record(again);
      if (again.at("cpu_seconds") < row.at("cpu_seconds")) row.update(again);
    }
    add(result, options, row);
    if (settings_.maps) write_map(model, result);
  } catch (const InputError& refusal) {
    row["refused"] = refusal.what();
  }
  return row;
}

double ObjectMeasurement::noise_of_patches(std::uint64_t photons) const {
  const double noise =
      error_against(reference_, patches_, reference_.exitance, 0.0).reference_error;
  return noise * std::sqrt(static_cast<double>(reference_.photons) / static_cast<double>(photons));
}

double ObjectMeasurement::error_of(const forward::ObjectResult& result) const {
  const std::vector<double> means = patches_.mean(result.exitance, bench_.object().surface);
  return error_against(reference_, patches_, means, 0.0).two_norm;
}

ObjectReference ObjectMeasurement::reference() const {
  const std::filesystem::path file = reference_file(settings_.references, object_);
  if (std::filesystem::exists(file)) return read_reference(object_, bench_, patches_, file);
  const ObjectReference made =
      measure_reference(bench_, patches_, settings_.reference_photons, request_.seed, progress_);
  write_reference(made, object_, bench_, patches_, file);
  return made;
}

void ObjectMeasurement::add(const forward::ObjectResult& result,
                            const forward::ObjectOptions& options, Json& row) const {
  const double allowed = validity_error(bench_);
  const ObjectError error = error_against(
      reference_, patches_, patches_.mean(result.exitance, bench_.object().surface), allowed);
  const forward::ObjectBalance& balance = result.balance.front();
  row["triangles"] = bench_.object().surface.size();
  row["size_over_mean_free_path"] = object_.size;
  row["thickness_over_mean_free_path"] = bench_.thickness;
  row["albedo"] = bench_.albedo;
  row["edges"] = features_.edges;
  row["contrast"] = features_.contrast;
  row["diffuse"] = features_.diffuse;
  row["slant"] = features_.slant;
  row["error"] = error.two_norm;
  row["reference_error"] = error.reference_error;
  row["mean_difference"] = error.mean;
  row["mean_difference_of_noise"] = error.mean_of_noise;
  row["validity_error"] = allowed;
  row["outside"] = error.outside;
  row["error_estimate"] = result.error_estimate.front();
  row["stated"] = result.error(0);
  row["covered"] = covered(result);
  row["elements"] = result.elements;
  row["tolerance"] = options.tolerance;
  row["reference_photons"] = reference_.photons;
  row["patches"] = patches_.size();
  row["iterations"] = result.iterations;
  row["balance"] =
      (balance.exiting + balance.absorbed + balance.unscattered) / balance.entering - 1.0;
  if (object_.light == CaseLight::sky && object_.shape == "sphere")
    row["exact_error"] = exact_error(result);
  row["converged"] = result.converged;
  row["warnings"] = result.warnings;
}

/// Share of the surface where the reference is within the map of errors, and two of its own.
double ObjectMeasurement::covered(const forward::ObjectResult& result) const {
  const Surface& surface = bench_.object().surface;
  std::vector<double> stated = forward::error_map(bench_.problem(), result, 0);
  for (std::size_t i = 0; i < stated.size(); ++i) stated[i] *= result.exitance[i];
  const std::vector<double> means = patches_.mean(result.exitance, surface);
  const std::vector<double> allowed = patches_.mean(stated, surface);
  double within = 0.0, area = 0.0;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const double difference = std::abs(means[p] - reference_.exitance[p]);
    const double most = std::hypot(allowed[p], 2.0 * reference_.standard_error[p]);
    if (difference <= most) within += patches_.area[p];
    area += patches_.area[p];
  }
  return within / area;
}

double ObjectMeasurement::exact_error(const forward::ObjectResult& result) const {
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
void ObjectMeasurement::write_map(const std::string& model,
                                  const forward::ObjectResult& result) const {
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

}  // namespace kappamu::studies
