#include "studies/inverse/unseen.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "data_synthetic/score.h"
#include "inverse/fit/fit_uncertainty.h"
#include "inverse/validation/validated_fit.h"
#include "studies/inverse/ablations.h"
#include "studies/inverse/coverage.h"
#include "studies/inverse/inverse_fit.h"
#include "tests/cases/limit_inverse_case.h"
#include "tests/cases/media.h"
#include "tests/cases/population.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

/// What is made of clean values.
struct Kind {
  std::string name;
  double noise = 0.01;
  Mistake mistake{};
  SmoothError shared{};
  bool right = true;
};

std::vector<Kind> kinds() {
  return {{"right, 0.3 % noise", 0.003},
          {"right, 1 % noise", 0.01},
          {"right, 3 % noise", 0.03},
          {"right, shared errors", 0.003, {}, {2e-4, 3e-4}},
          {"1.5 times too bright", 0.01, {.scale = 1.5}, {}, false},
          {"one voxel off", 0.01, {.shift = 1.0}, {}, false}};
}

struct Figure {
  std::string key, name;
  bool geometric = true;
};
const std::vector<Figure>& figures() {
  static const std::vector<Figure> all{{"validation_E", "E, 8 x 8 patches"},
                                       {"single_voxel_E", "E, single voxels"},
                                       {"kappa_error", "error of log kappa"},
                                       {"mu_error", "error of log mu"},
                                       {"kappa_within", "kappa within two deviations", false},
                                       {"mu_within", "mu within two deviations", false},
                                       {"accused", "scale or shift reported", false},
                                       {"block_scale", "scale, by a homogeneous block", false},
                                       {"too_bright", "too bright, by the volume", false},
                                       {"shifted", "shift", false},
                                       {"warnings", "warnings", false},
                                       {"simple", "simple model taken", false},
                                       {"work", "work"},
                                       {"batched_solves", "batched solves"}};
  return all;
}

double log_error(const Volume<double>& found, const Volume<double>& truth) {
  double squares = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    squares += std::pow(std::log(found[i] / truth[i]), 2) / static_cast<double>(found.size());
  }
  return std::sqrt(squares);
}

Json fit_row(const SurfaceMeasurements& data, const Validation& validation, const Block& block,
             const inverse::FitOptions& options) {
  Progress silent;
  const int apart = inverse::usual_validation_count(data.patterns);
  const inverse::ChannelFit fit =
      inverse::fit_validated(
          inverse::split_validation(data, inverse::choose_validation_patterns(data, apart)), 0,
          options, {}, {}, silent)
          .fit;
  const inverse::Uncertainty found =
      fit.prior ? inverse::estimate_volume_uncertainty(
                      fit, inverse::shared_deviation({&fit, 1}, data.lit_face), data)
                : inverse::estimate_model_uncertainty(fit, data, 0, options);
  const Medium fine = inverse::to_medium(validation.fine_fields, block.grid.refined(2));
  const Medium resolved = resolved_truth(fine, block, found.report.layers);
  const auto within = [&](const Volume<double>& volume, const Volume<double>& truth,
                          const Volume<float>& deviation) {
    return synthetic::coverage(volume, truth,
                               {block.grid, {deviation.values().begin(), deviation.values().end()}},
                               block.lit)
        .within_two;
  };
  const inverse::Consistency& c = fit.report.consistency;
  Json row = score_of(fit, data, validation.fine_fields);
  row["validation_E"] = appearance_error(fit.medium, validation.patches);
  row["single_voxel_E"] = appearance_error(fit.medium, validation.single);
  row["kappa_error"] =
      log_error(fit.medium.kappa, synthetic::average_volume(fine.kappa, block.grid));
  row["mu_error"] = log_error(fit.medium.mu, synthetic::average_volume(fine.mu, block.grid));
  row["kappa_within"] = within(fit.medium.kappa, resolved.kappa, found.log_kappa_std);
  row["mu_within"] = within(fit.medium.mu, resolved.mu, found.log_mu_std);
  row["accused"] = c.scale_is_wrong() || c.is_shifted() ? 1.0 : 0.0;
  row["block_scale"] = c.block_scale_is_wrong() ? 1.0 : 0.0;
  row["too_bright"] = c.is_too_bright() ? 1.0 : 0.0;
  row["shifted"] = c.is_shifted() ? 1.0 : 0.0;
  row["log_scale"] = c.log_scale.value;
  row["log_scale_limit"] = c.log_scale_limit;
  row["scale_gain"] = c.by_volume ? c.by_volume->scale_gain : 0.0;
  row["shift"] = std::hypot(c.shift_u.value, c.shift_v.value);
  row["shift_limit"] = c.shift_limit;
  row["warnings"] = static_cast<double>(fit.report.warnings.size());
  row["simple"] = fit.report.model.model == inverse::Model::volume ? 0.0 : 1.0;
  return row;
}

struct Mean {
  double value = 0.0, error = 0.0;
};
Mean mean_of(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double squares = 0.0;
  for (const double v : values) squares += std::pow(v - mean, 2);
  return {mean, count > 1.0 ? std::sqrt(squares / (count - 1.0) / count) : 0.0};
}

/// Of `figure`, by truth: its mean over the fits that `taken` takes.
template <class Taken>
std::map<std::string, double> by_truth(const Json& fits, const Figure& figure, const Taken& taken) {
  std::map<std::string, std::vector<double>> values;
  for (const Json& fit : fits) {
    if (!taken(fit)) continue;
    const double value = fit.at(figure.key).get<double>();
    values[fit.at("truth").get<std::string>()].push_back(figure.geometric ? std::log(value)
                                                                          : value);
  }
  std::map<std::string, double> means;
  for (const auto& [truth, of_it] : values) means[truth] = mean_of(of_it).value;
  return means;
}

Json table_of(const Json& fits, const Json& others) {
  std::vector<std::string> groups;
  for (const Kind& kind : kinds()) groups.push_back(kind.name);
  groups.emplace_back("all right");
  Json rows = Json::array();
  for (const std::string& group : groups) {
    const auto taken = [&](const Json& fit) {
      return fit.at("data") == group || (group == "all right" && fit.at("right").get<bool>());
    };
    for (const Figure& figure : figures()) {
      const auto here = by_truth(fits, figure, taken);
      if (here.empty()) continue;
      const auto there = by_truth(others, figure, taken);
      std::vector<double> values, differences;
      for (const auto& [truth, value] : here) {
        values.push_back(value);
        if (const auto at = there.find(truth); at != there.end()) {
          differences.push_back(value - at->second);
        }
      }
      const Mean mean = mean_of(values);
      Json row{
          {"data", group},
          {"figure", figure.name},
          {"mean", figure.geometric ? std::exp(mean.value) : mean.value},
          {"standard error", figure.geometric ? mean.error * std::exp(mean.value) : mean.error}};
      if (!differences.empty()) {
        const Mean paired = mean_of(differences);
        row["paired difference"] = paired.value;
        row["its standard error"] = paired.error;
      }
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace

void measure_unseen(const Request& request, Progress& progress, const Save& save) {
  const Block block = population_block(request.size == Size::full ? Size::small : request.size);
  const std::vector<double> light = bar_light(block.grid, block.lit, 8);
  inverse::FitOptions options;
  options.uncertainty.probes = inverse::usual_probes;
  options.solver.backend.device = request.device;
  constexpr int single_sources = 16;
  Json others = Json::array();
  if (request.has("against")) {
    others = read_record(request.words("against").front(), "inverse").at("fits");
  }
  Json fits = Json::array();
  for (int s = 0; s < request.count("seeds", 1); ++s) {
    const std::uint64_t seed = request.seed + static_cast<std::uint64_t>(s);
    for (const auto& [family_name, family] : family_names) {
      const std::string truth = family_name + std::string(", seed ") + std::to_string(seed);
      progress.update("unseen", 0.0, truth);
      const Validation validation = make_validation(
          block, make_family(block.grid.refined(2), family, block.grid.voxel_mm, seed),
          single_sources);
      const SurfaceMeasurements clean = expose(block, validation.fine_fields, light);
      for (const Kind& kind : kinds()) {
        SurfaceMeasurements data = clean;
        if (!kind.shared.none()) {
          Noise numbers(2000 + seed);
          add_smooth_error(data, kind.shared, numbers);
          data.smooth_error = kind.shared;
        }
        spoil(data, kind.noise, kind.mistake, 1000 + seed);
        Json row{
            {"truth", truth}, {"data", kind.name}, {"right", kind.right}, {"noise", kind.noise}};
        row.update(fit_row(data, validation, block, options));
        fits.push_back(row);
      }
      save({{"rows", table_of(fits, others)}, {"fits", fits}});
      if (request.size == Size::quick) return;
    }
  }
}

}  // namespace kappamu::studies
