#include "studies/inverse/inverse_bench.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "studies/inverse/ablations.h"
#include "studies/inverse/coverage.h"
#include "studies/inverse/inverse_fit.h"
#include "studies/inverse/inverse_samples.h"
#include "studies/inverse/unseen.h"
#include "studies/subjects.h"
#include "tests/cases/media.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

const std::vector<double> noises{0.0, 0.003, 0.01, 0.03};

struct Plan {
  GridShape grid;
  int truths;          ///< of section scores
  int course_points;   ///< scored per fit
  int single_sources;  ///< scored
  std::vector<double> noises;
};

Plan plan_of(Size size) {
  switch (size) {
    case Size::quick:
      return {{12, 12, 6, 0.5}, 1, 6, 4, {0.01}};
    case Size::small:
      return {{24, 24, 8, 0.5}, 2, 20, 16, noises};
    default:
      return {{32, 32, 10, 0.5}, 4, 40, 64, noises};
  }
}

/// What every section's measurement needs.
struct Bench {
  const Request& request;
  Progress& progress;
  const Save& save;
  Plan plan = plan_of(request.size);

  Block block(double noise) const {
    Block block;
    block.grid = plan.grid;
    block.noise = noise;
    return block;
  }
  inverse::CoefficientPair truth(const Block& block, int index, bool embedded = false) const {
    TruthSpec spec;
    spec.embedded = embedded;
    spec.seed = request.seed + static_cast<std::uint64_t>(index);
    return make_truth(block.grid.refined(2), spec);
  }
  inverse::FitOptions with_device(inverse::FitOptions fit) const {
    fit.solver.backend.device = request.device;
    return fit;
  }
  std::uint64_t noise_seed(int index) const {
    return 100 * request.seed + static_cast<std::uint64_t>(index);
  }
};

/// Without noise there is still rounding of the float values, and something to weight them by.
SurfaceMeasurements noisy(SurfaceMeasurements exposed, double noise, std::uint64_t seed) {
  constexpr double least = 1e-4;
  add_noise(exposed, noise > 0.0 ? noise : least, seed);
  return exposed;
}

Json optimisers_of(const Bench& bench) {
  Json fits = Json::array();
  const Block block = bench.block(0.0);
  const Validation validation =
      make_validation(block, bench.truth(block, 0), bench.plan.single_sources);
  const SurfaceMeasurements exposed = expose_patches(block, validation.fine_fields, 4);
  for (const double noise : bench.plan.noises) {
    const SurfaceMeasurements clean = exposed;
    SurfaceMeasurements m = noisy(clean, noise, bench.noise_seed(0));
    if (noise == 0.0) m.value = clean.value;
    double weight_of_default = 0.0;
    for (const Variant& variant : inverse_variants()) {
      inverse::FitOptions options = bench.with_device(variant.options);
      if (variant.weight_of_default) options.path.weight = weight_of_default;
      Json score = measure_fit(m, validation, options, KeptOut::none, bench.plan.course_points,
                               bench.progress);
      if (variant.name == "default") weight_of_default = score.at("weight").get<double>();
      score["variant"] = variant.name;
      score["label"] = variant.label;
      score["noise"] = noise;
      fits.push_back(score);
    }
  }
  return fits;
}

Json scores_of(const Bench& bench, bool embedded) {
  Json fits = Json::array();
  for (int k = 0; k < bench.plan.truths; ++k) {
    const Block block = bench.block(0.0);
    const Validation validation =
        make_validation(block, bench.truth(block, k, embedded), bench.plan.single_sources);
    const std::pair<const char*, std::vector<double>> lights[] = {
        {"bars", bar_light(block.grid, block.lit, 8)},
        {"patches", patch_light(block.grid, block.lit, 16)}};
    for (const auto& [name, light] : lights) {
      const SurfaceMeasurements exposed = expose(block, validation.fine_fields, light);
      for (const double noise : bench.plan.noises) {
        if (noise == 0.0) continue;
        Json score = measure_fit(noisy(exposed, noise, bench.noise_seed(k)), validation,
                                 bench.with_device({}), KeptOut::usual, 0, bench.progress);
        score["variant"] = name;
        score["noise"] = noise;
        fits.push_back(score);
      }
    }
  }
  return fits;
}

Json plain_scores_of(const Bench& bench) {
  return scores_of(bench, false);
}

Json embedded_scores_of(const Bench& bench) {
  return scores_of(bench, true);
}

Json patterns_of(const Bench& bench) {
  Json fits = Json::array();
  const int most = bench.request.size == Size::quick ? 3 : 8;
  for (const bool front_lit : {false, true}) {
    Block block = bench.block(0.01);
    if (front_lit) block.seen = block.lit;
    for (int k = 0; k < bench.plan.truths; ++k) {
      const Validation validation =
          make_validation(block, bench.truth(block, k), bench.plan.single_sources);
      const auto fit = [&](const std::string& shape, const std::vector<double>& light) {
        Json score = measure_fit(
            noisy(expose(block, validation.fine_fields, light), block.noise, bench.noise_seed(k)),
            validation, bench.with_device({}), KeptOut::usual, 0, bench.progress);
        score["variant"] = shape + (front_lit ? ", front-lit" : ", back-lit");
        score["noise"] = block.noise;
        fits.push_back(score);
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

Json voxels_of(const Bench& bench) {
  std::vector<GridShape> grids{{16, 16, 8, 0.5}, {32, 32, 10, 0.5}};
  if (bench.request.size != Size::quick) grids.push_back({64, 64, 12, 0.5});
  if (bench.request.size == Size::full) grids.push_back({128, 128, 20, 0.5});
  Json fits = Json::array();
  for (const GridShape& grid : grids) {
    Block block = bench.block(0.01);
    block.grid = grid;
    const Validation validation =
        make_validation(block, bench.truth(block, 0), bench.plan.single_sources);
    Json score = measure_fit(measure(block, validation.fine_fields, 4, bench.noise_seed(0)),
                             validation, bench.with_device({}), KeptOut::usual, 0, bench.progress);
    score["variant"] = "default";
    score["noise"] = block.noise;
    fits.push_back(score);
  }
  return fits;
}

/// Rows already in the record stay where their sample is not asked for.
Json samples_of(const Bench& bench) {
  const Request& request = bench.request;
  const auto file = record_file(request.folder, inverse_subject(), "samples");
  Json rows = Json::array();
  if (std::filesystem::exists(file)) rows = read_record(file, "inverse").at("rows");
  for (const std::string& name :
       request.has("sample") ? request.words("sample") : paper_samples()) {
    const Json row = measure_sample(name, request, bench.progress);
    const auto old = std::find_if(rows.begin(), rows.end(),
                                  [&](const Json& r) { return r.at("sample") == name; });
    if (old == rows.end()) {
      rows.push_back(row);
    } else {
      *old = row;
    }
    bench.save({{"rows", rows}});
  }
  return rows;
}

template <Json (*rows_of)(const Bench&)>
void measured(const Request& request, Progress& progress, const Save& save) {
  save({{"rows", rows_of({request, progress, save})}});
}

/// Rows of the default at 1 % noise, or all where there are none.
std::vector<Json> usual_rows(const Json& record) {
  std::vector<Json> rows;
  const Json& all = record.at("rows");
  for (const Json& row : all) {
    const auto variant = row.value("variant", "default");
    if ((variant == "default" || variant == "bars") &&
        std::abs(row.at("noise").get<double>() - 0.01) < 1e-9) {
      rows.push_back(row);
    }
  }
  if (rows.empty()) rows.assign(all.begin(), all.end());
  return rows;
}

}  // namespace

Json inverse_summary(const std::vector<Json>& records, const std::filesystem::path& /*folder*/) {
  const std::vector<std::string> order{"scores", "optimisers", "samples"};
  const auto rank = [&](const Json& record) {
    return std::find(order.begin(), order.end(), record.at("section")) - order.begin();
  };
  const Json& record =
      *std::min_element(records.begin(), records.end(),
                        [&](const Json& a, const Json& b) { return rank(a) < rank(b); });
  const bool samples = record.at("section") == "samples";
  std::vector<Json> rows = usual_rows(record);
  if (samples && record.contains("settings") && record.at("settings").contains("sample")) {
    const Json& asked = record.at("settings").at("sample");
    std::erase_if(rows, [&](const Json& row) {
      return std::find(asked.begin(), asked.end(), row.at("sample")) == asked.end();
    });
  }
  // The median truth stands for all. Of samples E is a list of channels: the first sample's.
  std::sort(rows.begin(), rows.end(), [](const Json& a, const Json& b) {
    return a.at("validation_E").is_number() && a.at("validation_E") < b.at("validation_E");
  });
  const Json& row = rows.at(samples ? 0 : rows.size() / 2);
  Json summary{{"sample", row.value("sample", "block")}, {"channels", row.value("channels", 1)}};
  for (const char* name : {"grid", "patterns", "noise"}) summary[name] = row.at(name);
  summary["optimiser"] = "default";
  for (const char* name :
       {"batched_solves", "seconds", "validation_E", "data_misfit_chi2", "device"}) {
    summary[name] = row.at(name);
  }
  summary["section"] = record.at("section");
  if (samples) summary["samples"] = rows;
  return summary;
}

Subject inverse_subject() {
  return {
      "inverse",
      "What fits cost and how good their volumes are, under light they never saw",
      R"(  kappamu-studies inverse -o out/bench                      all sections, about half an hour
  kappamu-studies inverse -o out/bench --section scores     one
  kappamu-studies inverse -o out/bench --small              smaller blocks, minutes

Truths are smooth random fields of contrast 4 with two boxes, solved on a grid twice as fine
as the fitted one; data get Gaussian noise relative to each value, with a floor.
E = sum (L' - L)^2 / sum L^2 of the exported volume, every voxel split 2x2x2 and nothing
corrected, against noise-free truth under 8x8 patches, or single voxels, that the fit never
saw. Solves are batched ones of all patterns on whatever grid, start included; work is their
iterations times voxels over the fitted grid's voxels.

--json: sample, grid, channels, patterns, noise, optimiser, batched_solves, seconds,
validation_E, data_misfit_chi2, device, of the median truth at 1 % noise, or of the sample
asked for.

Do not trust seconds on a machine that does anything else.)",
      {{"optimisers", "E along the fit by every optimiser, at noise 0, 0.3, 1, 3 %",
        measured<optimisers_of>},
       {"scores", "the default over several truths and seeds, under bars and under patches",
        measured<plain_scores_of>},
       {"embedded", "the same with smaller boxes, none at a face", measured<embedded_scores_of>},
       {"patterns", "by number of images, patches and bars, back-lit and front-lit",
        measured<patterns_of>},
       {"voxels", "cost against the size of the block", measured<voxels_of>},
       {"samples", "wax1, wax2, marble, stone at the paper's sizes, R, G, B: a quarter of an hour",
        measured<samples_of>},
       {"validation", "0, 1, 2, 4 of 16 patterns kept out", measure_validation},
       {"regularisers", "h1, huber-tv at several edge slopes, [W]'s at several weights",
        measure_regularisers},
       {"population", "four families of truths, bars and patches, 0.3, 1 and 3 % noise",
        measure_population},
       {"coverage", "stated deviations against such truths, by layer", measure_coverage},
       {"unseen", "fits of right and wrong data of such truths, beside those of another build",
        measure_unseen},
       {"losses", "gaussian, huber, student, with and without 1 % of outliers", measure_losses}},
      {{"sample", "Of section samples, these alone; the record keeps the others' rows",
        Setting::Kind::words, 0, 0, paper_samples()},
       {"seeds",
        "Of validation, regularisers and losses: noises per truth; of population, coverage and "
        "unseen: truths of each family (default 1)",
        Setting::Kind::number, 1, 100},
       {"against", "Of unseen: the record of another build, whose fits are the pairs",
        Setting::Kind::words}},
      inverse_summary};
}

}  // namespace kappamu::studies
