#include "bench/choices.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "bench/chart.h"
#include "bench/inverse_case.h"
#include "bench/inverse_fit.h"
#include "bench/record.h"
#include "core/error.h"
#include "inverse/fit/fit.h"
#include "inverse/problem/held_out.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;
using inverse::CoefficientPair;
using inverse::FitOptions;

struct Truth {
  std::string name;
  CoefficientPair fine_fields;
};

/// Smooth fields of contrast 4 with and without two boxes, and layers along the light.
std::vector<Truth> choice_truths(const GridShape& fine, std::uint64_t seed) {
  TruthSpec boxes;
  boxes.seed = seed;
  TruthSpec smooth = boxes;
  smooth.inclusions = false;
  CoefficientPair layers{std::vector<double>(fine.cells()), std::vector<double>(fine.cells())};
  for (std::size_t i = 0; i < fine.cells(); ++i) {
    const auto z = static_cast<int>(i / static_cast<std::size_t>(fine.nx) / fine.ny);
    const bool deep = 3 * z >= fine.nz;
    layers.log_kappa[i] = std::log(deep ? 0.15 : 0.4);
    layers.log_mu[i] = std::log(deep ? 0.04 : 0.01);
  }
  return {{"boxes", make_truth(fine, boxes)},
          {"smooth", make_truth(fine, smooth)},
          {"layers", std::move(layers)}};
}

/// One way to fit, and what is done to the data first.
struct Choice {
  std::string name;
  FitOptions options;
  std::vector<int> held_out;                         ///< patterns not fitted
  std::function<void(SurfaceMeasurements&)> damage;  ///< the same for all ways of a subject
};

/// One datum in a hundred, anywhere, becomes up to its pattern's maximum.
void make_wild(SurfaceMeasurements& m) {
  constexpr std::uint64_t seed = 5;
  constexpr double share = 0.01;
  Noise noise(seed);
  const std::size_t cells = m.seen_shape().cells();
  for (std::size_t p = 0; p < static_cast<std::size_t>(m.patterns); ++p) {
    const auto first = m.value.begin() + static_cast<std::ptrdiff_t>(p * cells);
    const float largest = *std::max_element(first, first + static_cast<std::ptrdiff_t>(cells));
    for (std::size_t i = p * cells; i < (p + 1) * cells; ++i) {
      if (noise.uniform() < share) m.value[i] = static_cast<float>(largest * noise.uniform());
    }
  }
}

/// Every pattern's light is up to 3 % other than stated.
void make_drift(SurfaceMeasurements& m) {
  constexpr std::uint64_t seed = 6;
  constexpr double largest = 0.03;
  Noise noise(seed);
  const std::size_t cells = m.seen_shape().cells();
  for (std::size_t p = 0; p < static_cast<std::size_t>(m.patterns); ++p) {
    const auto gain = static_cast<float>(1.0 + largest * (2.0 * noise.uniform() - 1.0));
    for (std::size_t i = p * cells; i < (p + 1) * cells; ++i) {
      m.value[i] *= gain;
      m.variance[i] *= gain * gain;
    }
  }
}

std::vector<Choice> ways_of(const std::string& subject) {
  using inverse::Loss;
  using inverse::RegulariserKind;
  using inverse::WeightRule;
  std::vector<Choice> ways;
  const auto add = [&](const std::string& name) -> Choice& {
    ways.emplace_back();
    ways.back().name = name;
    return ways.back();
  };
  if (subject == "held-out") {
    add("0 of 16");
    add("1 of 16").held_out = {5};
    add("2 of 16").held_out = {5, 10};
    add("4 of 16").held_out = {5, 6, 9, 10};
    add("1 of 16, a corner").held_out = {0};
  } else if (subject == "weight") {
    for (const WeightRule rule :
         {WeightRule::discrepancy, WeightRule::l_curve, WeightRule::held_out}) {
      Choice& way = add(to_string(rule));
      way.options.weight_rule = rule;
      way.held_out = {5};  // of all three alike
    }
  } else if (subject == "regulariser") {
    add("h1");
    for (const double slope : {8.0, 4.0, 2.0, 1.0}) {
      char name[32];
      std::snprintf(name, sizeof name, "huber-tv, t = %g", slope);
      FitOptions& options = add(name).options;
      options.regulariser.kind = RegulariserKind::huber_tv;
      options.regulariser.edge_slope = slope;
    }
    for (const double lambda : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
      char name[32];
      std::snprintf(name, sizeof name, "wang2008, %g", lambda);
      FitOptions& options = add(name).options;
      options.regulariser.kind = RegulariserKind::wang2008;
      options.weight = lambda;
    }
  } else if (subject == "loss") {
    for (const Loss loss : {Loss::gaussian, Loss::huber, Loss::student}) {
      add(to_string(loss) + ", clean").options.data_term.loss = loss;
      Choice& wild = add(to_string(loss) + ", 1 % wild");
      wild.options.data_term.loss = loss;
      wild.damage = make_wild;
    }
  } else if (subject == "gains") {
    add("no drift");
    add("no drift, gains").options.data_term.gain_spread = 0.03;
    add("drift").damage = make_drift;
    Choice& both = add("drift, gains");
    both.options.data_term.gain_spread = 0.03;
    both.damage = make_drift;
  } else {
    throw InputError("bench choices: unknown subject '" + subject + "'");
  }
  return ways;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

ChoiceScore score_choice(const Choice& way, SurfaceMeasurements measured, const Judge& judge,
                         const std::string& device, Progress& progress) {
  if (way.damage) way.damage(measured);
  FitOptions options = way.options;
  options.model = inverse::Model::volume;
  options.backend.device = device;
  inverse::FitContext context;
  if (!way.held_out.empty()) context.held_out = inverse::select_patterns(measured, way.held_out);
  const inverse::ChannelFit fit = inverse::fit_channel(
      inverse::without_patterns(measured, way.held_out), 0, options, {}, progress, {}, context);
  const DepthError depth = depth_error(fit.medium, judge.fine_fields, measured.lit_face);
  ChoiceScore score;
  score.way = way.name;
  score.patches_error = appearance_error(fit.medium, judge.patches);
  score.single_error = appearance_error(fit.medium, judge.single);
  score.kappa_error = mean(depth.kappa);
  score.mu_error = mean(depth.mu);
  score.chi2 = fit.report.chi2_per_value;
  score.weight = fit.report.weight;
  score.solves = fit.report.solves.total();
  return score;
}

}  // namespace

const std::vector<std::string>& choice_subjects() {
  static const std::vector<std::string> subjects{"held-out", "weight", "regulariser", "loss",
                                                 "gains"};
  return subjects;
}

std::vector<ChoiceScore> measure_choices(const std::string& subject, const ChoicesOptions& options,
                                         Progress& progress) {
  const std::vector<Choice> ways = ways_of(subject);
  Block block;
  std::vector<Truth> truths = choice_truths(block.grid.refined(2), options.seed);
  truths.resize(std::min(truths.size(), static_cast<std::size_t>(std::max(1, options.truths))));
  std::vector<ChoiceScore> scores;
  Progress silent;
  const double all = static_cast<double>(truths.size() * ways.size() * options.noise.size()) *
                     static_cast<double>(options.seeds);
  for (const Truth& truth : truths) {
    const Judge judge = make_judge(block, truth.fine_fields);
    for (const double noise : options.noise) {
      block.noise = noise;
      for (int s = 0; s < options.seeds; ++s) {
        const std::uint64_t seed = options.seed + 100 + static_cast<std::uint64_t>(s);
        const SurfaceMeasurements measured = measure(block, truth.fine_fields, 4, seed);
        for (const Choice& way : ways) {
          progress.update(subject, static_cast<double>(scores.size()) / all,
                          truth.name + ", " + way.name);
          scores.push_back(score_choice(way, measured, judge, options.device, silent));
          scores.back().truth = truth.name;
          scores.back().noise = noise;
          scores.back().seed = seed;
        }
      }
    }
  }
  return scores;
}

namespace {

/// The distinct values of a member, in the order measured.
template <class T>
std::vector<T> distinct(const std::vector<ChoiceScore>& scores, T ChoiceScore::*member) {
  std::vector<T> values;
  for (const ChoiceScore& s : scores) {
    if (std::find(values.begin(), values.end(), s.*member) == values.end()) {
      values.push_back(s.*member);
    }
  }
  return values;
}

double median_of(const std::vector<ChoiceScore>& scores, const std::string& way, double noise,
                 double ChoiceScore::*member) {
  std::vector<double> values;
  for (const ChoiceScore& s : scores) {
    if (s.way == way && s.noise == noise) values.push_back(s.*member);
  }
  return median(std::move(values));
}

Chart chart_of(const std::vector<ChoiceScore>& scores, const std::string& label,
               double ChoiceScore::*member) {
  Chart chart;
  chart.x_label = "noise, relative";
  chart.y_label = label;
  chart.log_x = chart.log_y = true;
  for (const std::string& way : distinct(scores, &ChoiceScore::way)) {
    Series series;
    series.label = way;
    for (const double noise : distinct(scores, &ChoiceScore::noise)) {
      series.x.push_back(noise);
      series.y.push_back(median_of(scores, way, noise, member));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

void draw_choices(const std::vector<ChoiceScore>& scores, const std::filesystem::path& png) {
  const std::vector<Chart> charts{
      chart_of(scores, "E under held-out 8 x 8 patches", &ChoiceScore::patches_error),
      chart_of(scores, "median error of κ", &ChoiceScore::kappa_error)};
  draw(charts, png, 2);
}

std::string choices_table(const std::vector<ChoiceScore>& scores) {
  // In the order measured.
  std::vector<std::pair<double, std::string>> rows;
  for (const ChoiceScore& s : scores) {
    const auto key = std::make_pair(s.noise, s.way);
    if (std::find(rows.begin(), rows.end(), key) == rows.end()) rows.push_back(key);
  }
  std::string table =
      "| noise | way | E, 8 × 8 patches: median | worst | E, single voxels: median | κ error | μ "
      "error | χ² | solves |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [noise, way] : rows) {
    std::vector<double> patches, single, kappa, mu, chi2, solves;
    for (const ChoiceScore& s : scores) {
      if (s.noise != noise || s.way != way) continue;
      patches.push_back(s.patches_error);
      single.push_back(s.single_error);
      kappa.push_back(s.kappa_error);
      mu.push_back(s.mu_error);
      chi2.push_back(s.chi2);
      solves.push_back(s.solves);
    }
    const double worst = *std::max_element(patches.begin(), patches.end());
    char row[256];
    std::snprintf(row, sizeof row,
                  "| %g %% | %s | %.2e | %.2e | %.2e | %.1f %% | %.1f %% | %.3g | %.0f |\n",
                  100.0 * noise, way.c_str(), median(patches), worst, median(single),
                  100.0 * median(kappa), 100.0 * median(mu), median(chi2), median(solves));
    table += row;
  }
  return table;
}

Json choices_record(const std::string& subject, const ChoicesOptions& options,
                    const std::vector<ChoiceScore>& scores) {
  Json record = record_header("choices", options.device);
  record["subject"] = subject;
  record["seed"] = options.seed;
  record["scores"] = Json::array();
  for (const ChoiceScore& s : scores) {
    record["scores"].push_back({{"way", s.way},
                                {"truth", s.truth},
                                {"noise", s.noise},
                                {"seed", s.seed},
                                {"holdout_E", s.patches_error},
                                {"single_voxel_E", s.single_error},
                                {"kappa_error", s.kappa_error},
                                {"mu_error", s.mu_error},
                                {"data_misfit_chi2", s.chi2},
                                {"weight", s.weight},
                                {"batched_solves", s.solves}});
  }
  return record;
}

}  // namespace kappamu::bench
