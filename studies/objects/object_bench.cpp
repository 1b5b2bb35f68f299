#include "studies/objects/object_bench.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/optics.h"
#include "forward/registry.h"
#include "studies/objects/object_measurement.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

std::vector<ObjectCase> cases_of(const Request& request) {
  std::vector<std::string> wanted = request.words("scenes");
  if (request.has("draw")) return drawn_cases(request.count("draw", 0), request.seed, wanted);
  std::vector<ObjectCase> own = cases_of_files(request.words("mesh"));
  if (wanted.empty() && !own.empty()) return own;
  if (wanted.empty() && request.size == Size::quick) {
    wanted = {"sphere-marble-8-sky", "box-with-void-marble-8"};
  }
  if (wanted.empty() && request.size == Size::small) {
    wanted = {"sphere-marble-24", "cube-marble-24", "bob-marble-24", "bob-skin1-24"};
  }
  std::vector<ObjectCase> cases = object_cases(Population::tuning, wanted);
  cases.insert(cases.end(), own.begin(), own.end());
  return cases;
}

void measure_models(const Request& request, Progress& progress, const Save& save) {
  const ObjectSettings settings = object_settings(request);
  const std::vector<ObjectCase> cases = cases_of(request);
  for (const std::string& model : settings.models) forward::make_object_model(model);
  Json rows = Json::array();
  for (const ObjectCase& object : cases) {
    const ObjectMeasurement measurement(object, settings, request, progress);
    for (const std::string& model : settings.models) {
      rows.push_back(measurement.row(model, measurement.options(), settings.photons));
      save({{"tolerance", settings.tolerance}, {"photons", settings.photons}, {"rows", rows}});
    }
  }
}

/// One object for each scene and model, or for each choice.
Json rows_of(const std::vector<Json>& records, const std::filesystem::path& /*folder*/) {
  return records.at(0).at("rows");
}

}  // namespace

double exitance_of_lit_sphere(double radius_mm, double kappa_mm, double mu_per_mm, double eta) {
  const BoundaryConstants constants = boundary_constants(eta);
  const double decay = std::sqrt(mu_per_mm / kappa_mm), x = decay * radius_mm;
  const double i0 = std::sinh(x) / x, slope = (std::cosh(x) - i0) / x;
  const double entering = eta * eta * (1.0 - constants.r_phi);
  const double q = entering * constants.q_per_entering();
  const double phi = q * i0 / (i0 + 2.0 * constants.A * kappa_mm * decay * slope);
  return (phi - q) / (2.0 * constants.A) + entering;
}

Subject objects_subject() {
  return {
      "objects",
      "Error and time of every model of objects, against Monte Carlo on the same scenes",
      R"(  kappamu-studies objects -o out/bench                           all, half an hour
  kappamu-studies objects -o out/bench --scenes bob --models embedded
  kappamu-studies objects -o out/bench --quick                   two toy scenes, seconds

Scenes are <shape>-<material>-<size>: named shapes and the meshes of scenes/meshes, the red
channel of published materials or a measured block, the box's longest edge over the mean
free path, under parallel light from aslant; -side, -below: from there, -sky: even diffuse
light. --mesh FILE: that object in marble of 8, 24 and 72 and in skin2 of 24.

error: relative 2-norm over the surface of the difference from Monte Carlo in patches of
1/8 of the object, what the reference's noise adds taken off; reference_error: that noise.
mean_difference: mean of |difference| over the mean exitance, noise included, which alone
would make it mean_difference_of_noise. validity_error: largest error of diffusion that
docs/validity.md has for a slab of this albedo and of thickness 2V/S; outside: share of the
surface where the difference exceeds it by more than three standard errors. stated: the error
that the model states against transport; covered: share of the surface where its map of errors
and two standard errors hold the difference. exact_error:
against the closed form of diffusion. balance: power out over power in, less 1. A model that
refuses a scene has its sentence in the row instead.

References are read from studies/objects/references in the working directory; one that is
missing is measured, minutes, and recorded there.

Section auto: of every validation scene and tolerance the model that is taken, its error
and processor time; met: the error is within the tolerance; cheapest: the model of those
that met it with the least processor time; cost_ratio: the taken one's over that.
--draw N measures N scenes drawn at random by --seed instead, or those of --scenes among them.

Section refinement: diffusion on cubes refined by the model's own estimate beside even ones,
from mesh to exitance of one light and channel; error: from that on some millions of cubes.

Section estimate: the error that this model states of its numerics, and its true one, on
scenes drawn by --seed (or --scenes) and on --mesh files, at three tolerances.

Section invariance: what half and twice as long triangle edges on one surface, and an object and
its coefficients scaled together, change of the exitance, relative 2-norm over the coarser mesh's
triangles; and of round shapes what half and twice as large facets do, which are other bodies.

Section picture: wall seconds from mesh file to picture of scenes/nefertiti-marble.json, and
of the same scene with each --mesh FILE in the bust's place; medians of three.

Do not trust seconds on a machine that does anything else; cpu_seconds (all threads together)
suffer less.)",
      {{"models", "Every model on the tuning scenes", measure_models},
       {"cost", "Seconds against triangles and elements, a marble torus under an even sky",
        measure_costs},
       {"auto", "What model auto takes on the validation scenes, and what it should have",
        measure_auto},
       {"refinement", "Time against error of refined and even cubes", measure_refinement},
       {"estimate", "The error that cubes state of themselves, and the true one",
        measure_estimates},
       {"invariance", "What tessellation and scale change of an answer", measure_invariance},
       {"picture", "Seconds from mesh file to picture", measure_pictures}},
      {{"scenes", "Those whose names begin so; all if absent", Setting::Kind::words},
       {"mesh", "Files of objects to measure instead of, or beside, those of --scenes",
        Setting::Kind::words},
       {"draw", "Measure of so many scenes drawn by --seed those of --scenes",
        Setting::Kind::number, 1, 1000},
       {"models", "Those named; all if absent", Setting::Kind::words},
       {"tolerance", "Error that models aim at (default 0.01)", Setting::Kind::number, 1e-6, 0.9},
       {"photons", "Of the model montecarlo (default 200000)", Setting::Kind::number, 2, 2e9},
       {"reference-photons", "Of references to be measured (default 2000000)",
        Setting::Kind::number, 2, 2e9},
       {"references", "Folder of recorded references (default studies/objects/references)",
        Setting::Kind::words},
       {"meshes", "Folder of meshes (default scenes/meshes)", Setting::Kind::words},
       {"volume", "The measured block (default studies/objects/volume)", Setting::Kind::words},
       {"maps", "Also write exitance per triangle, objects-map-<scene>-<model>.npy",
        Setting::Kind::flag}},
      rows_of};
}

}  // namespace kappamu::studies
