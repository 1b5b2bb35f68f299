#include "bench/inverse/inverse_samples.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "bench/cases/inverse_case.h"
#include "bench/cases/media.h"
#include "capture/rig/shoot.h"
#include "data_synthetic/scene/materials.h"
#include "inverse/fit/fit.h"

namespace kappamu::bench {

namespace {

constexpr double sample_noise = 0.01;

/// Smaller variants keep the depth of the block and its structure's size.
synthetic::SampleModel sized(const std::string& name, const Request& request) {
  synthetic::SampleModel sample = synthetic::make_sample(name, request.seed);
  if (request.size == Size::full) return sample;
  const int share = request.size == Size::small ? 4 : 8;
  const GridShape& g = sample.grid;
  return synthetic::make_sample(
      name, request.seed,
      std::array<int, 3>{std::max(12, g.nx / share), std::max(12, g.ny / share), g.nz});
}

/// Every eighth of the 8 × 8 patches, in another column each time.
std::vector<double> validation_light(const Block& block) {
  const std::vector<double> all = patch_light(block.grid, block.lit, 64);
  const auto cells = static_cast<std::ptrdiff_t>(all.size() / 64);
  std::vector<double> light;
  for (const std::ptrdiff_t patch : {3, 12, 22, 33, 36, 45, 51, 62}) {
    light.insert(light.end(), all.begin() + patch * cells, all.begin() + (patch + 1) * cells);
  }
  return light;
}

}  // namespace

const std::vector<std::string>& paper_samples() {
  static const std::vector<std::string> names{"wax1", "wax2", "marble", "stone"};
  return names;
}

Json measure_sample(const std::string& name, const Request& request, Progress& progress) {
  const synthetic::SampleModel sample = sized(name, request);
  Block block;
  block.grid = sample.grid;
  block.lit = sample.lit_face();
  block.seen = sample.seen_face();
  block.noise = sample_noise;
  block.precision = forward::Precision::single_precision;
  const std::vector<double> light = bar_light(block.grid, block.lit, capture::FitLight{}.n);
  const std::array<Medium, 3> truth = synthetic::sample_medium(sample, block.grid.refined(2));
  Json record{{"sample", name},
              {"grid", {block.grid.nx, block.grid.ny, block.grid.nz}},
              {"channels", truth.size()},
              {"patterns", 16},
              {"noise", sample_noise}};
  double seconds = 0.0;
  double deviation_seconds = 0.0;
  int solves = 0;
  Json errors = Json::array();
  Json misfits = Json::array();
  for (std::size_t channel = 0; channel < truth.size(); ++channel) {
    const inverse::CoefficientPair fields = inverse::to_fields(truth[channel]);
    SurfaceMeasurements measured = expose(block, fields, light);
    add_noise(measured, sample_noise, request.seed + channel);
    inverse::FitOptions fit_options;
    fit_options.solver.backend.device = request.device;
    fit_options.uncertainty.samples = 2;  // the default of `kappamu fit`
    const inverse::ChannelFit fit =
        inverse::fit_channel(measured, 0, fit_options, {}, progress, {}, {});
    const double on_deviations = fit.uncertainty ? fit.uncertainty->report.seconds : 0.0;
    seconds += fit.report.seconds - on_deviations;
    deviation_seconds += on_deviations;
    solves += fit.report.solves.total();
    misfits.push_back(fit.report.chi2_per_value);
    errors.push_back(appearance_error(fit.medium, expose(block, fields, validation_light(block))));
    record["device"] = fit.report.backend;
  }
  record["seconds"] = seconds;
  record["deviation_seconds"] = deviation_seconds;
  record["batched_solves"] = solves;
  record["validation_E"] = errors;
  record["data_misfit_chi2"] = misfits;
  return record;
}

}  // namespace kappamu::bench
