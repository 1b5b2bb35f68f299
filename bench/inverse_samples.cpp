#include "bench/inverse_samples.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/inverse_case.h"
#include "bench/media.h"
#include "bench/text.h"
#include "capture/rig/shoot.h"
#include "data_synthetic/scene/materials.h"
#include "inverse/fit/fit.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

constexpr double noise = 0.01;

/// Smaller variants keep the depth of the block and its structure's size.
synthetic::SampleModel sized(const std::string& name, const InverseBenchOptions& options) {
  synthetic::SampleModel sample = synthetic::make_sample(name, options.seed);
  if (options.size == BenchSize::full) return sample;
  const int share = options.size == BenchSize::small ? 4 : 8;
  const GridShape& g = sample.grid;
  return synthetic::make_sample(
      name, options.seed,
      std::array<int, 3>{std::max(12, g.nx / share), std::max(12, g.ny / share), g.nz});
}

/// Every eighth of the 8 × 8 patches, in another column each time.
std::vector<double> judging_light(const Block& block) {
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

double paper_hours(const std::string& sample) {
  static const std::map<std::string, double> hours{
      {"wax1", 2.0}, {"wax2", 4.0}, {"marble", 11.0}, {"stone", 3.0}};
  return hours.at(sample);
}

Json measure_sample(const std::string& name, const InverseBenchOptions& options,
                    Progress& progress) {
  const synthetic::SampleModel sample = sized(name, options);
  Block block;
  block.grid = sample.grid;
  block.lit = sample.lit_face();
  block.seen = sample.seen_face();
  block.noise = noise;
  block.precision = forward::Precision::single_precision;
  const std::vector<double> light = bar_light(block.grid, block.lit, capture::FitLight{}.n);
  const std::array<Medium, 3> truth = synthetic::sample_medium(sample, block.grid.refined(2));
  Json record{{"sample", name},
              {"grid", {block.grid.nx, block.grid.ny, block.grid.nz}},
              {"channels", truth.size()},
              {"patterns", 16},
              {"noise", noise}};
  double seconds = 0.0;
  double deviation_seconds = 0.0;
  int solves = 0;
  Json errors = Json::array();
  Json misfits = Json::array();
  for (std::size_t channel = 0; channel < truth.size(); ++channel) {
    const inverse::CoefficientPair fields = inverse::to_fields(truth[channel]);
    SurfaceMeasurements measured = expose(block, fields, light);
    add_noise(measured, noise, options.seed + channel);
    inverse::FitOptions fit_options;
    fit_options.backend.device = options.device;
    fit_options.uncertainty.samples = 2;  // the default of `kappamu fit`
    const inverse::ChannelFit fit =
        inverse::fit_channel(measured, 0, fit_options, {}, progress, {}, {});
    const double on_deviations = fit.uncertainty ? fit.uncertainty->report.seconds : 0.0;
    seconds += fit.report.seconds - on_deviations;
    deviation_seconds += on_deviations;
    solves += fit.report.solves.total();
    misfits.push_back(fit.report.chi2_per_value);
    errors.push_back(appearance_error(fit.medium, expose(block, fields, judging_light(block))));
    record["device"] = fit.report.backend;
  }
  record["seconds"] = seconds;
  record["deviation_seconds"] = deviation_seconds;
  record["batched_solves"] = solves;
  record["holdout_E"] = errors;
  record["data_misfit_chi2"] = misfits;
  return record;
}

std::string sample_table(const Json& rows) {
  std::string table =
      "| sample | voxels | paper [h] | ours, to volumes [s] | their deviations [s] | solves | "
      "E of R, G, B | χ² |\n|---|---|---|---|---|---|---|---|\n";
  const auto listed = [](const Json& values, const auto& digits) {
    std::string list;
    for (const Json& value : values) {
      list += (list.empty() ? "" : ", ") + digits(value.get<double>());
    }
    return list;
  };
  for (const Json& row : rows) {
    const auto name = row.at("sample").get<std::string>();
    const auto grid = row.at("grid").get<std::array<int, 3>>();
    table += "| " + name + " | " + std::to_string(grid[0]) + " × " + std::to_string(grid[1]) +
             " × " + std::to_string(grid[2]) + " | " + text("%.0f", paper_hours(name)) + " | " +
             text("%.0f", row.at("seconds").get<double>()) + " | " +
             text("%.0f", row.at("deviation_seconds").get<double>()) + " | " +
             std::to_string(row.at("batched_solves").get<int>()) + " | " +
             listed(row.at("holdout_E"), [](double e) { return text("%.1e", e); }) + " | " +
             listed(row.at("data_misfit_chi2"), [](double c) { return text("%.2f", c); }) + " |\n";
  }
  return table;
}

}  // namespace kappamu::bench
