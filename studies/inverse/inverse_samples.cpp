#include "studies/inverse/inverse_samples.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "capture/rig/shoot.h"
#include "core/processor_time.h"
#include "core/threads/side_by_side.h"
#include "data_synthetic/scene/materials.h"
#include "data_synthetic/score.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_memory.h"
#include "inverse/fit/fit_uncertainty.h"
#include "studies/inverse/coverage.h"
#include "studies/inverse/inverse_fit.h"
#include "tests/cases/inverse_case.h"
#include "tests/cases/media.h"

namespace kappamu::studies {

using namespace test_cases;

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

/// Of all voxels and of the worst layer.
Json share_within(const Volume<double>& found, const Volume<double>& truth,
                  const Volume<float>& log_deviation, Face lit) {
  const synthetic::Coverage share = synthetic::coverage(
      found, truth, {truth.shape(), {log_deviation.values().begin(), log_deviation.values().end()}},
      lit);
  return {{"all", share.within_two},
          {"worst_layer",
           *std::min_element(share.within_two_by_depth.begin(), share.within_two_by_depth.end())}};
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
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
  inverse::FitOptions fit_options;
  fit_options.solver.backend.device = request.device;
  fit_options.uncertainty.probes = inverse::usual_probes;
  int solves = 0;
  Json errors = Json::array();
  Json misfits = Json::array();
  Json work = Json::array(), channel_solves = Json::array(), weights = Json::array();
  Json kappa_errors = Json::array(), mu_errors = Json::array(), single_errors = Json::array();
  const auto cells = static_cast<double>(block.grid.cells());
  const std::vector<double> single = single_voxel_light(face_shape(block.grid, block.lit), 16, 11);
  std::vector<SurfaceMeasurements> measured;
  std::vector<std::string> names;
  for (std::size_t channel = 0; channel < truth.size(); ++channel) {
    measured.push_back(expose(block, inverse::to_fields(truth[channel]), light));
    add_noise(measured.back(), sample_noise, request.seed + channel);
    names.push_back(std::to_string(channel));
  }
  const int at_once =
      inverse::fits_at_once(inverse::memory_needed(measured.front(), fit_options),
                            fit_options.solver.backend, static_cast<int>(truth.size()));
  std::vector<inverse::ChannelFit> fits(truth.size());
  const Stopwatch fitting;
  side_by_side("fit", names, at_once, progress, [&](std::size_t channel, Progress& of_channel) {
    fits[channel] = inverse::fit_channel(measured[channel], 0, fit_options, {}, of_channel, {}, {});
  });
  const double seconds = fitting.seconds();
  for (std::size_t channel = 0; channel < truth.size(); ++channel) {
    const inverse::CoefficientPair fields = inverse::to_fields(truth[channel]);
    const inverse::ChannelFit& fit = fits[channel];
    solves += fit.report.solves.total();
    work.push_back(fit.report.solves.voxel_iterations / cells);
    channel_solves.push_back(fit.report.solves.total());
    weights.push_back(fit.report.weight);
    const DepthError depth = depth_error(fit.medium, fields, block.lit);
    kappa_errors.push_back(mean(depth.kappa));
    mu_errors.push_back(mean(depth.mu));
    single_errors.push_back(appearance_error(fit.medium, expose(block, fields, single)));
    misfits.push_back(fit.report.chi2_per_value);
    errors.push_back(appearance_error(fit.medium, expose(block, fields, validation_light(block))));
    record["device"] = fit.report.backend;
  }
  record["seconds"] = seconds;
  record["work"] = work;
  record["channel_solves"] = channel_solves;
  record["weight"] = weights;
  record["single_voxel_E"] = single_errors;
  record["kappa_error"] = kappa_errors;
  record["mu_error"] = mu_errors;
  double deviation_seconds = 0.0;
  const inverse::SharedDeviation shared = inverse::shared_deviation(fits, block.lit);
  Json kappa_coverage = Json::array();
  Json mu_coverage = Json::array();
  for (std::size_t channel = 0; channel < fits.size(); ++channel) {
    if (!fits[channel].prior) continue;
    const Stopwatch watch;
    const inverse::Uncertainty found =
        inverse::estimate_volume_uncertainty(fits[channel], shared, measured[channel]);
    deviation_seconds += watch.seconds();
    const Medium& medium = fits[channel].medium;
    const Medium resolved = resolved_truth(truth[channel], block, found.report.layers);
    kappa_coverage.push_back(
        share_within(medium.kappa, resolved.kappa, found.log_kappa_std, block.lit));
    mu_coverage.push_back(share_within(medium.mu, resolved.mu, found.log_mu_std, block.lit));
  }
  record["deviation_seconds"] = deviation_seconds;
  record["batched_solves"] = solves;
  record["validation_E"] = errors;
  record["data_misfit_chi2"] = misfits;
  record["kappa_coverage"] = kappa_coverage;
  record["mu_coverage"] = mu_coverage;
  return record;
}

}  // namespace kappamu::studies
