#include "bench/inverse/systematic_bench.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "bench/cases/limit_inverse_case.h"
#include "bench/cases/systematic_case.h"
#include "inverse/fit/model_uncertainty.h"

namespace kappamu::bench {

namespace {

constexpr GridShape grid{20, 16, 8, 0.5};
constexpr int patterns = 8;
constexpr double noise = 0.003;

struct Kind {
  const char* name;
  inverse::Model model;
};
constexpr std::array<Kind, 3> kinds{{{"homogeneous", inverse::Model::homogeneous},
                                     {"four layers", inverse::Model::layered},
                                     {"two inclusions", inverse::Model::volume}}};

/// κ and μ vary from block to block.
Figure3 figure_of(const Kind& kind, std::uint64_t seed) {
  Noise chance(seed);
  const double kappa = 0.2 * std::exp(0.4 * chance.normal());
  const double mu = 0.02 * std::exp(0.5 * chance.normal());
  switch (kind.model) {
    case inverse::Model::homogeneous:
      return even_block(kappa, mu);
    case inverse::Model::layered:
      return random_layers(kappa, mu, seed);
    default:
      return inclusions(kappa, mu, 1.2 + 0.8 * chance.uniform());
  }
}

/// Over the blocks of one row.
struct Counts {
  int blocks = 0;
  int right = 0;                   ///< of the kind they are
  double found = 0.0;              ///< sum of the sizes found
  std::array<double, 2> within{};  ///< shares of values within two deviations of the truth, summed
};

void add_block(const Kind& kind, double size, std::uint64_t seed, const Request& request,
               Counts& counts) {
  constexpr int finer = 3;
  Block block;
  block.grid = grid;
  const Figure3 figure = figure_of(kind, seed);
  SurfaceMeasurements m = expose_figure(block, figure, bar_light(grid, patterns), finer, 1.3);
  add_rig_error(m, size, seed);
  add_noise(m, noise, seed + 1);
  inverse::FitOptions options;
  options.solver.backend.device = request.device;
  Progress silent;
  inverse::ChannelFit fit = inverse::fit_channel(m, 0, options, {}, silent);
  const inverse::ModelChoice& model = fit.report.model;
  if (model.model != inverse::Model::volume) {
    fit.uncertainty = inverse::estimate_model_uncertainty(fit, m, 0, options);
  }
  const inverse::CoefficientPair truth = on_grid(grid, figure);
  std::array<int, 2> within{};
  for (std::size_t i = 0; i < grid.cells(); ++i) {
    const double kappa = std::log(fit.medium.kappa[i]) - truth.log_kappa[i];
    const double mu = std::log(fit.medium.mu[i]) - truth.log_mu[i];
    within[0] += std::abs(kappa) <= 2.0 * fit.uncertainty->log_kappa_std[i] ? 1 : 0;
    within[1] += std::abs(mu) <= 2.0 * fit.uncertainty->log_mu_std[i] ? 1 : 0;
  }
  ++counts.blocks;
  counts.right += model.model == kind.model ? 1 : 0;
  counts.found += model.systematic;
  for (std::size_t q = 0; q < 2; ++q) {
    counts.within[q] += within[q] / static_cast<double>(grid.cells());
  }
}

void measure(const Request& request, Progress& progress, const Save& save) {
  const int blocks = request.count("blocks", request.size == Size::full    ? 20
                                             : request.size == Size::small ? 5
                                                                           : 1);
  constexpr std::array<double, 4> sizes{0.001, 0.002, 0.005, 0.01};
  Json rows = Json::array();
  for (const Kind& kind : kinds) {
    for (const double size : sizes) {
      Counts counts;
      for (int k = 0; k < blocks; ++k) {
        progress.update("systematic", static_cast<double>(rows.size()) / 12.0,
                        std::string(kind.name) + ", block " + std::to_string(k + 1));
        const std::uint64_t seed = request.seed * 1000 + rows.size() * 100;
        add_block(kind, size, seed + static_cast<std::uint64_t>(k), request, counts);
      }
      rows.push_back({{"block", kind.name},
                      {"error_percent", 100.0 * size},
                      {"blocks", counts.blocks},
                      {"of_its_kind", counts.right},
                      {"error_found_percent", 100.0 * counts.found / counts.blocks},
                      {"kappa_within_2_percent", 100.0 * counts.within[0] / counts.blocks},
                      {"mu_within_2_percent", 100.0 * counts.within[1] / counts.blocks}});
      save({{"grid", {grid.nx, grid.ny, grid.nz}},
            {"patterns", patterns},
            {"noise", noise},
            {"rows", rows}});
    }
  }
}

}  // namespace

Subject systematic_subject() {
  return {"systematic",
          "Models chosen and deviations stated where measurements have systematic errors",
          "  kappamu bench systematic -o out/bench            20 blocks a row, an hour\n"
          "  kappamu bench systematic -o out/bench --small    5 blocks a row\n\n"
          "Blocks of 20 x 16 x 8 voxels that are homogeneous, of four layers or with two\n"
          "inclusions, κ and μ by chance, under eight bars. Data are of a grid three times as\n"
          "fine, with 0.3 % noise and errors that all patterns share: interpolation between\n"
          "camera pixels, a shift, the response's exponent, mixed by chance to the size stated.\n"
          "Per row: blocks fitted as what they are, and the share of voxels whose κ and μ lie\n"
          "within two stated deviations of the truth (95 % were they normal).",
          {{"systematic", "all", measure}},
          {{"blocks", "Blocks a row (default 20)", Setting::Kind::number, 1, 10000}}};
}

}  // namespace kappamu::bench
