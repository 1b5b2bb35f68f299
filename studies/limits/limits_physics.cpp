// Absorption and voxel size: where the grid, rather than its solver, meets its edge.
#include <cmath>

#include "forward/analytic/layered_mode.h"
#include "studies/limits/limits.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using forward::Precision;
using forward::SourceModel;

double relative(double value, double truth) {
  return std::abs(value / truth - 1.0);
}

std::string verdict(const LimitOutcome& outcome) {
  return outcome.warnings.empty() ? "nothing" : "warns";
}

/// What a slab of the block's depth sends back and lets through, over what enters.
struct SlabLight {
  double reflected = 0.0, transmitted = 0.0;
};
SlabLight slab_light(const forward::GridSetup& setup, double kappa, double mu) {
  const BoundaryConstants constants = boundary_constants(setup.eta);
  const std::vector<forward::Layer> layers{{kappa, mu, setup.shape.nz * setup.shape.voxel_mm}};
  const double entering = constants.normal_transmittance;
  const bool boundary = setup.source == SourceModel::boundary;
  const forward::ModeSource source =
      boundary ? forward::ModeSource{.q = 4.0 * entering / (1.0 - constants.r_phi)}
               : forward::ModeSource{.beam = entering, .reflectance = 1.0 - entering};
  const forward::LayeredMode slab(layers, constants.A, source);
  // Under the boundary source the flux out is a net one; E_t enters besides.
  const double apart = boundary ? entering : 0.0;
  return {(slab.flux_out_near() + apart) / entering, slab.flux_out_far() / entering};
}

}  // namespace

Json limit_absorption(const Request& request, Progress& progress) {
  Json rows = Json::array();
  constexpr double kappa = 0.3;
  for (const double mu : {0.0, 1e-6, 1e-3, 1e-1, 1.0, 10.0, 100.0}) {
    progress.update("absorption", 0.0, Json(mu).dump());
    LimitCase limit{.setup = {.shape = {16, 16, 20, 0.25},
                              .sides = Sides::mirror,
                              .source = SourceModel::boundary},
                    .medium = {.mean_kappa = kappa, .mu = mu},
                    .device = request.device};
    const LimitOutcome outcome = run_limit(limit);
    limit.options.tolerance = 1e-12;
    limit.precision = Precision::double_precision;
    const LimitOutcome best = run_limit(limit);
    const SlabLight slab = slab_light(limit.setup, kappa, mu);
    rows.push_back({{"μ [1/mm]", mu},
                    {"voxels per penetration depth", std::sqrt(kappa / mu) / 0.25},
                    {"iterations", outcome.iterations},
                    {"true error", *outcome.true_error},
                    {"transmitted", best.transmitted},
                    {"its error, 1e-6 single", *outcome.dark_error},
                    {"its error, 1e-12 double", *best.dark_error},
                    {"grid's error of it", relative(best.transmitted, slab.transmitted)},
                    {"program", verdict(outcome)}});
  }
  return rows;
}

Json limit_coarse(const Request& request, Progress& progress) {
  Json rows = Json::array();
  constexpr double mean_free_path = 1.0, thickness = 16.0, mu = 0.01;
  constexpr double kappa = mean_free_path / 3.0;
  for (const int deep : {128, 64, 32, 16, 8, 4, 2, 1}) {
    const double h = thickness / deep;
    progress.update("coarse", 0.0, Json(h).dump());
    Json row{{"voxel / mean free path", h / mean_free_path}};
    std::string program;
    for (const SourceModel source : {SourceModel::first_collision, SourceModel::boundary}) {
      const LimitCase limit{
          .setup = {.shape = {4, 4, deep, h}, .sides = Sides::mirror, .source = source},
          .medium = {.mean_kappa = kappa, .mu = mu},
          .options = {1e-12, 200},
          .precision = Precision::double_precision,
          .device = request.device,
          .with_error = false};
      const LimitOutcome outcome = run_limit(limit);
      const SlabLight slab = slab_light(limit.setup, kappa, mu);
      const std::string name =
          source == SourceModel::boundary ? ", boundary source" : ", first collision";
      row["reflected" + name] = relative(outcome.reflected, slab.reflected);
      row["transmitted" + name] = relative(outcome.transmitted, slab.transmitted);
      if (source == SourceModel::first_collision) program = verdict(outcome);
    }
    row["program, first collision"] = program;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace kappamu::studies
