#include "bench/inverse_bench.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/inverse_fit.h"
#include "bench/inverse_photons.h"
#include "bench/inverse_samples.h"
#include "bench/media.h"
#include "bench/record.h"
#include "core/error.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

const std::vector<double> noises{0.0, 0.003, 0.01, 0.03};

struct Plan {
  GridShape grid;
  int truths;          ///< of section scores
  int course_points;   ///< scored per fit
  int single_sources;  ///< judged
  std::vector<double> noises;
};

Plan plan_of(BenchSize size) {
  switch (size) {
    case BenchSize::quick:
      return {{12, 12, 6, 0.5}, 1, 6, 4, {0.01}};
    case BenchSize::small:
      return {{24, 24, 8, 0.5}, 2, 20, 16, noises};
    default:
      return {{32, 32, 10, 0.5}, 4, 40, 64, noises};
  }
}

/// What every section's measurement needs.
struct Bench {
  const InverseBenchOptions& options;
  Progress& progress;
  Plan plan = plan_of(options.size);

  Block block(double noise) const {
    Block block;
    block.grid = plan.grid;
    block.noise = noise;
    return block;
  }
  inverse::CoefficientPair truth(const Block& block, int index, bool embedded = false) const {
    TruthSpec spec;
    spec.embedded = embedded;
    spec.seed = options.seed + static_cast<std::uint64_t>(index);
    return make_truth(block.grid.refined(2), spec);
  }
  inverse::FitOptions with_device(inverse::FitOptions fit) const {
    fit.solver.backend.device = options.device;
    return fit;
  }
  std::uint64_t noise_seed(int index) const {
    return 100 * options.seed + static_cast<std::uint64_t>(index);
  }
};

std::filesystem::path record_file(const InverseBenchOptions& options, const std::string& section) {
  return options.folder / ("inverse-" + section + ".json");
}

/// Without noise there is still rounding of the float values, and something to weight them by.
SurfaceMeasurements noisy(SurfaceMeasurements exposed, double noise, std::uint64_t seed) {
  constexpr double least = 1e-4;
  add_noise(exposed, noise > 0.0 ? noise : least, seed);
  return exposed;
}

Json measure_optimisers(const Bench& bench) {
  Json fits = Json::array();
  const Block block = bench.block(0.0);
  const Judge judge = make_judge(block, bench.truth(block, 0), bench.plan.single_sources);
  const SurfaceMeasurements exposed = expose_patches(block, judge.fine_fields, 4);
  for (const double noise : bench.plan.noises) {
    const SurfaceMeasurements clean = exposed;
    SurfaceMeasurements m = noisy(clean, noise, bench.noise_seed(0));
    if (noise == 0.0) m.value = clean.value;
    double weight_of_default = 0.0;
    for (const Way& way : inverse_ways()) {
      inverse::FitOptions options = bench.with_device(way.options);
      if (way.weight_of_default) options.path.weight = weight_of_default;
      FitScore score =
          measure_fit(m, judge, options, Judged::no, bench.plan.course_points, bench.progress);
      if (way.name == "default") weight_of_default = score.weight;
      score.way = way.name;
      score.noise = noise;
      fits.push_back(to_json(score));
    }
  }
  return fits;
}

Json scores_of(const Bench& bench, bool embedded) {
  Json fits = Json::array();
  for (int k = 0; k < bench.plan.truths; ++k) {
    const Block block = bench.block(0.0);
    const Judge judge =
        make_judge(block, bench.truth(block, k, embedded), bench.plan.single_sources);
    const std::pair<const char*, std::vector<double>> lights[] = {
        {"bars", bar_light(block.grid, block.lit, 8)},
        {"patches", patch_light(block.grid, block.lit, 16)}};
    for (const auto& [name, light] : lights) {
      const SurfaceMeasurements exposed = expose(block, judge.fine_fields, light);
      for (const double noise : bench.plan.noises) {
        if (noise == 0.0) continue;
        FitScore score =
            measure_fit(noisy(exposed, noise, bench.noise_seed(k)), judge, bench.with_device({}),
                        Judged::by_own_patterns, 0, bench.progress);
        score.way = name;
        score.noise = noise;
        fits.push_back(to_json(score));
      }
    }
  }
  return fits;
}

Json measure_scores(const Bench& bench) {
  return scores_of(bench, false);
}

Json measure_embedded(const Bench& bench) {
  return scores_of(bench, true);
}

Json measure_patterns(const Bench& bench) {
  Json fits = Json::array();
  const int most = bench.options.size == BenchSize::quick ? 3 : 8;
  for (const bool front_lit : {false, true}) {
    Block block = bench.block(0.01);
    if (front_lit) block.seen = block.lit;
    for (int k = 0; k < bench.plan.truths; ++k) {
      const Judge judge = make_judge(block, bench.truth(block, k), bench.plan.single_sources);
      const auto fit = [&](const std::string& shape, const std::vector<double>& light) {
        FitScore score = measure_fit(
            noisy(expose(block, judge.fine_fields, light), block.noise, bench.noise_seed(k)), judge,
            bench.with_device({}), Judged::by_own_patterns, 0, bench.progress);
        score.way = shape + (front_lit ? ", front-lit" : ", back-lit");
        score.noise = block.noise;
        fits.push_back(to_json(score));
      };
      // A single patch, seen from where it falls, leaves nothing in the dark.
      for (int n = front_lit ? 2 : 1; n <= most; ++n) {
        fit("patches", patch_light(block.grid, block.lit, n * n));
      }
      for (const int n : {2, 4, 6, 8, 12, 16}) {
        if (n <= 2 * most) fit("bars", bar_light(block.grid, block.lit, n));
      }
    }
  }
  return fits;
}

Json measure_voxels(const Bench& bench) {
  std::vector<GridShape> grids{{16, 16, 8, 0.5}, {32, 32, 10, 0.5}};
  if (bench.options.size != BenchSize::quick) grids.push_back({64, 64, 12, 0.5});
  if (bench.options.size == BenchSize::full) grids.push_back({128, 128, 20, 0.5});
  Json fits = Json::array();
  for (const GridShape& grid : grids) {
    Block block = bench.block(0.01);
    block.grid = grid;
    const Judge judge = make_judge(block, bench.truth(block, 0), bench.plan.single_sources);
    FitScore score = measure_fit(measure(block, judge.fine_fields, 4, bench.noise_seed(0)), judge,
                                 bench.with_device({}), Judged::by_own_patterns, 0, bench.progress);
    score.way = "default";
    score.noise = block.noise;
    fits.push_back(to_json(score));
  }
  return fits;
}

Json measure_monte_carlo(const Bench& bench) {
  Block block = bench.block(0.0);
  PhotonOptions photons;
  photons.device = bench.options.device;
  photons.seed = bench.options.seed;
  if (bench.options.size == BenchSize::full) {
    block.grid = {16, 16, 8, 0.5};
    photons.per_pattern = 4'000'000;
    photons.judged_patterns = 16;
  } else {
    block.grid = {12, 12, 6, 0.5};
    const bool quick = bench.options.size == BenchSize::quick;
    photons.per_pattern = quick ? 50'000 : 400'000;
    photons.judged_patterns = 4;
  }
  const PhotonFit fit =
      fit_monte_carlo(block, bench.truth(block, 0), bench.with_device({}), photons, bench.progress);
  return Json::array({to_json(fit)});
}

/// Rows already in the record stay where their sample is not asked for.
Json measure_samples(const Bench& bench) {
  const auto file = record_file(bench.options, "samples");
  Json rows = Json::array();
  if (std::filesystem::exists(file)) rows = read_record(file, "inverse").at("fits");
  for (const std::string& name :
       bench.options.samples.empty() ? paper_samples() : bench.options.samples) {
    const Json row = measure_sample(name, bench.options, bench.progress);
    const auto old = std::find_if(rows.begin(), rows.end(),
                                  [&](const Json& r) { return r.at("sample") == name; });
    if (old == rows.end()) {
      rows.push_back(row);
    } else {
      *old = row;
    }
  }
  return rows;
}

}  // namespace

const std::vector<std::string>& inverse_sections() {
  static const std::vector<std::string> sections{"optimisers", "scores",     "embedded", "patterns",
                                                 "voxels",     "montecarlo", "samples"};
  return sections;
}

void measure_inverse(const std::string& section, const InverseBenchOptions& options,
                     Progress& progress) {
  const Bench bench{options, progress};
  using Measure = Json (*)(const Bench&);
  const std::vector<std::pair<std::string, Measure>> measures{
      {"optimisers", measure_optimisers}, {"scores", measure_scores},
      {"embedded", measure_embedded},     {"patterns", measure_patterns},
      {"voxels", measure_voxels},         {"montecarlo", measure_monte_carlo},
      {"samples", measure_samples}};
  const auto found = std::find_if(measures.begin(), measures.end(),
                                  [&](const auto& m) { return m.first == section; });
  if (found == measures.end()) {
    throw InputError("section '" + section + "' is unknown; see kappamu bench inverse --help.");
  }
  Json record = record_header("inverse", options.device);
  record["section"] = section;
  record["seed"] = options.seed;
  record["size"] = options.size == BenchSize::full    ? "full"
                   : options.size == BenchSize::small ? "small"
                                                      : "quick";
  record["fits"] = found->second(bench);
  write_record(record, record_file(options, section));
}

Json inverse_summary(const std::filesystem::path& folder) {
  using SectionAndWay = std::pair<std::string, std::string>;
  for (const auto& [section, way] :
       {SectionAndWay{"scores", "bars"}, SectionAndWay{"optimisers", "default"}}) {
    const auto file = folder / ("inverse-" + section + ".json");
    if (!std::filesystem::exists(file)) continue;
    const Json record = read_record(file, "inverse");
    std::vector<FitScore> at_one_percent;
    for (const Json& object : record.at("fits")) {
      FitScore score = fit_score_from_json(object);
      if (score.way == way && std::abs(score.noise - 0.01) < 1e-9) {
        at_one_percent.push_back(std::move(score));
      }
    }
    if (at_one_percent.empty()) continue;
    // The median truth stands for all.
    std::sort(
        at_one_percent.begin(), at_one_percent.end(),
        [](const FitScore& a, const FitScore& b) { return a.patches_error < b.patches_error; });
    const FitScore& s = at_one_percent[at_one_percent.size() / 2];
    return {{"sample", "block"},
            {"grid", {s.grid.nx, s.grid.ny, s.grid.nz}},
            {"channels", 1},
            {"patterns", s.patterns},
            {"noise", s.noise},
            {"optimiser", "default"},
            {"batched_solves", s.solves},
            {"seconds", s.seconds},
            {"holdout_E", s.patches_error},
            {"data_misfit_chi2", s.chi2},
            {"device", s.backend}};
  }
  throw InputError("nothing to sum up in " + folder.string() +
                   ": measure section scores or optimisers first.");
}

}  // namespace kappamu::bench
