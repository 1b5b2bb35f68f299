#include "studies/inverse/ablations.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/shown_text.h"
#include "inverse/validation/validation_patterns.h"
#include "studies/inverse/inverse_fit.h"
#include "tests/cases/inverse_case.h"
#include "tests/cases/media.h"
#include "tests/cases/population.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using inverse::CoefficientPair;
using inverse::FitOptions;

struct Truth {
  std::string name;
  CoefficientPair fine_fields;
};

/// Smooth fields of contrast 4 with and without two boxes, and layers along the light.
std::vector<Truth> truths_of(const GridShape& fine, std::uint64_t seed) {
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

/// One set of options, and what is done to the data first.
struct Ablation {
  std::string name;
  FitOptions options;
  std::vector<int> kept_out;                         ///< patterns not fitted
  std::function<void(SurfaceMeasurements&)> damage;  ///< the same for all of a section
};

/// One datum in a hundred, anywhere, becomes up to its pattern's maximum.
void add_outliers(SurfaceMeasurements& m) {
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

void measure_ablations(const std::vector<Ablation>& ablations, const Request& request,
                       Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick, full = request.size == Size::full;
  Block block;
  if (quick) block.grid = {8, 8, 4, 0.5};
  const int seeds = request.count("seeds", 1);
  std::vector<Truth> truths = truths_of(block.grid.refined(2), request.seed);
  if (!full) truths.resize(1);
  Progress silent;
  Json rows = Json::array();
  for (const Truth& truth : truths) {
    const Validation validation = make_validation(block, truth.fine_fields);
    for (const double noise : quick ? std::vector<double>{0.01} : std::vector{0.003, 0.01, 0.03}) {
      block.noise = noise;
      for (int s = 0; s < seeds; ++s) {
        const std::uint64_t seed = request.seed + 100 + static_cast<std::uint64_t>(s);
        const SurfaceMeasurements measured = measure(block, truth.fine_fields, 4, seed);
        for (const Ablation& ablation : ablations) {
          progress.update("ablations", 0.0, truth.name + ", " + ablation.name);
          SurfaceMeasurements data = measured;
          if (ablation.damage) ablation.damage(data);
          FitOptions options = ablation.options;
          options.path.model = inverse::Model::volume;
          options.solver.backend.device = request.device;
          Json row{
              {"variant", ablation.name}, {"truth", truth.name}, {"noise", noise}, {"seed", seed}};
          row.update(measure_fit(inverse::without_patterns(data, ablation.kept_out), validation,
                                 options, KeptOut::none, 0, silent));
          rows.push_back(row);
        }
      }
    }
    save({{"rows", rows}});
  }
}

}  // namespace

void measure_validation(const Request& request, Progress& progress, const Save& save) {
  std::vector<Ablation> ablations;
  const std::vector<std::pair<const char*, std::vector<int>>> kept_out{{"0 of 16", {}},
                                                                       {"1 of 16", {5}},
                                                                       {"2 of 16", {5, 10}},
                                                                       {"4 of 16", {5, 6, 9, 10}},
                                                                       {"1 of 16, a corner", {0}}};
  for (const auto& [name, patterns] : kept_out) {
    ablations.push_back({name, FitOptions{}, patterns, {}});
  }
  measure_ablations(ablations, request, progress, save);
}

void measure_regularisers(const Request& request, Progress& progress, const Save& save) {
  std::vector<Ablation> ablations;
  FitOptions smooth;
  smooth.regulariser.kind = inverse::RegulariserKind::h1;
  ablations.push_back({"h1", smooth, {}, {}});
  for (const double slope : {8.0, 4.0, 2.0, 1.0}) {
    FitOptions options;
    options.regulariser.kind = inverse::RegulariserKind::huber_tv;
    options.regulariser.edge_slope = slope;
    ablations.push_back({shown_number(slope, "huber-tv, t = %g"), options, {}, {}});
  }
  for (const double lambda : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
    FitOptions options;
    options.regulariser.kind = inverse::RegulariserKind::wang2008;
    options.path.weight = lambda;
    ablations.push_back({shown_number(lambda, "wang2008, %g"), options, {}, {}});
  }
  measure_ablations(ablations, request, progress, save);
}

Block population_block(Size size) {
  Block block;
  block.grid = size == Size::quick   ? GridShape{8, 8, 4, 0.5}
               : size == Size::small ? GridShape{16, 16, 8, 0.5}
                                     : GridShape{32, 32, 10, 0.5};
  block.precision = forward::Precision::single_precision;
  return block;
}

void measure_population(const Request& request, Progress& progress, const Save& save) {
  const Block block = population_block(request.size);
  const std::pair<const char*, std::vector<double>> lights[] = {
      {"bars", bar_light(block.grid, block.lit, 8)},
      {"patches", patch_light(block.grid, block.lit, 16)}};
  FitOptions options;
  options.path.model = inverse::Model::volume;
  options.solver.backend.device = request.device;
  constexpr int single_sources = 32;
  Progress silent;
  Json rows = Json::array();
  for (int s = 0; s < request.count("seeds", 1); ++s) {
    const std::uint64_t seed = request.seed + static_cast<std::uint64_t>(s);
    for (const auto& [name, family] : family_names) {
      progress.update("population", 0.0, name + std::string(", seed ") + std::to_string(seed));
      const Validation validation = make_validation(
          block, make_family(block.grid.refined(2), family, block.grid.voxel_mm, seed),
          single_sources);
      for (const auto& [light, irradiance] : lights) {
        const SurfaceMeasurements clean = expose(block, validation.fine_fields, irradiance);
        for (const double noise : {0.003, 0.01, 0.03}) {
          SurfaceMeasurements data = clean;
          add_noise(data, noise, 1000 + seed);
          Json row{{"variant", std::string(light) + ", " + name}, {"noise", noise}, {"seed", seed}};
          row.update(measure_fit(data, validation, options, KeptOut::none, 0, silent));
          rows.push_back(row);
        }
      }
      save({{"rows", rows}});
      if (request.size == Size::quick) return;
    }
  }
}

void measure_losses(const Request& request, Progress& progress, const Save& save) {
  std::vector<Ablation> ablations;
  for (const inverse::Loss loss :
       {inverse::Loss::gaussian, inverse::Loss::huber, inverse::Loss::student}) {
    FitOptions options;
    options.data.term.loss = loss;
    ablations.push_back({to_string(loss) + ", clean", options, {}, {}});
    ablations.push_back({to_string(loss) + ", 1 % outliers", options, {}, add_outliers});
  }
  measure_ablations(ablations, request, progress, save);
}

}  // namespace kappamu::studies
