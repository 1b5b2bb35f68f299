// Where diffusion can be trusted: its error against Monte Carlo transport over albedo and optical
// thickness, on slabs under patch light.
//
// Each case is a slab of index 1.3 and transport mean free path 1 mm (κ = 1/3 mm, μ = 1 − albedo
// per mm, isotropic scattering), three thicknesses wide with mirror sides, lit by a collimated beam
// on a square as wide as the slab is thick, seen in pixels of an eighth of that. Diffusion is the
// closed form (forward/analytic/layered_block.h) with the first-collision source and exact A, so no
// grid's error enters. Diffuse light only: what crosses unscattered is left out on both sides.
// Reflected and transmitted are signed relative errors of the totals, lit_map and far_map relative
// L2 errors of the pixel maps less the noise's part; null where Monte Carlo's noise hides them.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/shown_text.h"
#include "forward/forward_model.h"
#include "forward/montecarlo/monte_carlo_model.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

using forward::ForwardProblem;
using forward::ForwardResult;

struct Options {
  std::vector<double> albedos{0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999};
  std::vector<double> thicknesses{1, 2, 4, 8, 16, 32, 50};  ///< mean free paths
  std::uint64_t photons = 1'000'000;                        ///< per case
};

/// One error of diffusion and what Monte Carlo's noise leaves of it, both relative.
struct RelativeError {
  double value = 0.0;  ///< diffusion / Monte Carlo − 1, or ‖difference‖/‖Monte Carlo‖
  double standard_error = 0.0;  ///< of `value`
  /// Noise is a third of the error at most, or half a percent.
  bool resolved() const { return standard_error < std::max(0.005, std::abs(value) / 3.0); }
};

constexpr int pixels_thick = 8, pixels_wide = 24;
constexpr std::size_t lit = 4, far = 5;  // z-, z+ in all_faces

ForwardProblem problem_of(double albedo, double mean_free_paths) {
  ForwardProblem problem;
  problem.setup.sides = Sides::mirror;
  problem.setup.shape = {pixels_wide, pixels_wide, pixels_thick, mean_free_paths / pixels_thick};
  const GridShape& s = problem.setup.shape;
  problem.medium = {Volume<double>(s, 1.0 / 3.0), Volume<double>(s, 1.0 - albedo)};
  constexpr int first = (pixels_wide - pixels_thick) / 2, last = first + pixels_thick;
  for (int y = 0; y < pixels_wide; ++y) {
    for (int x = 0; x < pixels_wide; ++x) {
      const bool bright = x >= first && x < last && y >= first && y < last;
      problem.irradiance.push_back(bright ? 1.0 : 0.0);
    }
  }
  return problem;
}

RelativeError total_error(const ForwardResult& diffusion, const ForwardResult& transport,
                          std::size_t face, const ForwardProblem& problem, std::uint64_t photons) {
  const double theirs = transport.balance[0].exiting[face];
  if (theirs <= 0.0) return {0.0, 1.0};
  const double h = problem.setup.shape.voxel_mm;
  const auto& map = transport.exitance[face];
  const double noise =
      forward::standard_error_of_mean(map, transport.standard_error[face],
                                      transport.balance[0].entering, h * h, photons) *
      static_cast<double>(map.size()) * h * h / theirs;
  const double ratio = diffusion.balance[0].exiting[face] / theirs;
  return {ratio - 1.0, noise * ratio};
}

/// The expected square of the noise is taken off the square of the difference. That square's own
/// variance is Σ 4d²σ² + 2σ⁴ over the pixels, d the error proper.
RelativeError map_error(const ForwardResult& diffusion, const ForwardResult& transport,
                        std::size_t face) {
  double square = 0.0, variance = 0.0, norm = 0.0;
  for (std::size_t k = 0; k < transport.exitance[face].size(); ++k) {
    const double theirs = transport.exitance[face][k];
    const double noise = std::pow(transport.standard_error[face][k], 2);
    const double difference = std::pow(diffusion.exitance[face][k] - theirs, 2);
    square += difference - noise;
    variance += 4.0 * std::max(0.0, difference - noise) * noise + 2.0 * noise * noise;
    norm += theirs * theirs;
  }
  if (norm <= 0.0) return {0.0, 1.0};
  const double value = std::max(0.0, square) / norm, error = std::sqrt(variance) / norm;
  return {std::sqrt(value), value > error ? error / (2.0 * std::sqrt(value)) : std::sqrt(error)};
}

void add(Json& row, const std::string& name, const RelativeError& error) {
  row[name] = error.resolved() ? Json(error.value) : Json(nullptr);
  row[name + "_standard_error"] = error.standard_error;
}

void measure(const Request& request, Progress& progress, const Save& save) {
  Options options;
  if (request.size == Size::quick) options = {{0.7, 0.9, 0.99}, {2, 8, 32}, 100'000};
  const auto analytic = forward::make_forward_model("analytic");
  const auto monte_carlo = forward::make_forward_model("montecarlo");
  forward::ForwardOptions settings;
  settings.device = request.device;
  settings.photons = options.photons;
  settings.seed = request.seed;
  const auto count = static_cast<double>(options.albedos.size() * options.thicknesses.size());
  Progress silent;
  Json rows = Json::array();
  for (const double albedo : options.albedos) {
    for (const double paths : options.thicknesses) {
      progress.update("validity", static_cast<double>(rows.size()) / count,
                      formatted("albedo %g, %g mean free paths", albedo, paths));
      const ForwardProblem problem = problem_of(albedo, paths);
      const ForwardResult ours = analytic->solve(problem, settings, silent);
      const ForwardResult theirs = monte_carlo->solve(problem, settings, silent);
      ++settings.seed;                        // no two cases share their noise
      const double incident = paths * paths;  // irradiance 1 on the patch
      Json row{{"albedo", albedo},
               {"mean_free_paths", paths},
               {"reflectance", theirs.balance[0].exiting[lit] / incident},
               {"transmittance", theirs.balance[0].exiting[far] / incident}};
      add(row, "reflected", total_error(ours, theirs, lit, problem, options.photons));
      add(row, "transmitted", total_error(ours, theirs, far, problem, options.photons));
      add(row, "lit_map", map_error(ours, theirs, lit));
      add(row, "far_map", map_error(ours, theirs, far));
      rows.push_back(row);
    }
  }
  save({{"photons", options.photons}, {"eta", 1.3}, {"rows", rows}});
}

}  // namespace

Subject validity_subject() {
  return {
      "validity",
      "Error of diffusion against Monte Carlo over albedo and thickness (docs/validity.md)",
      R"(  kappamu-studies validity -o out/            56 slabs, 10^6 photons each: a few minutes
  kappamu-studies validity --quick -o out/    9 slabs, 10^5 photons each: seconds

Reflected and transmitted totals, and the maps of both faces under a patch. From the
record studies/bench_charts.py also writes validity_table.inc, which forward/analytic/
holds a copy of for the program's own warnings.)",
      {{"validity", "all slabs", measure}}};
}

}  // namespace kappamu::studies
