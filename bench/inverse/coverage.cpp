#include "bench/inverse/coverage.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/cases/inverse_case.h"
#include "bench/cases/media.h"
#include "bench/cases/population.h"
#include "bench/inverse/ablations.h"
#include "data_synthetic/score.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_uncertainty.h"

namespace kappamu::bench {

namespace {

/// `truth` on the grid of `found`.
Json layers_of(const Volume<double>& found, const Volume<double>& truth,
               const Volume<float>& log_deviation, Face lit) {
  const GridShape& grid = found.shape();
  const FaceShape face = face_shape(grid, lit);
  const auto cells = static_cast<double>(face.cells());
  Json error = Json::array(), stated = Json::array();
  for (int depth = 0; depth < grid.extent(axis_of(lit)); ++depth) {
    double sum = 0.0, squares = 0.0;
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const std::size_t i = face_cell(grid, lit, u, v, depth);
        const double deviation = log_deviation[i];
        sum += std::log(found[i] / truth[i]);
        squares += deviation * deviation;
      }
    }
    error.push_back(sum / cells);
    stated.push_back(std::sqrt(squares / cells));
  }
  const synthetic::Coverage share = synthetic::coverage(
      found, truth, {grid, {log_deviation.values().begin(), log_deviation.values().end()}}, lit);
  return {{"within", share.within_two_by_depth}, {"error", error}, {"stated", stated}};
}

Json fit_row(const SurfaceMeasurements& data, const Medium& fine_truth,
             const inverse::FitOptions& options) {
  Progress silent;
  const inverse::ChannelFit fit = inverse::fit_channel(data, 0, options, {}, silent, {}, {});
  const double valley = inverse::shared_valley({&fit, 1}, data.lit_face);
  const inverse::Uncertainty found = inverse::estimate_volume_uncertainty(fit, valley, data);
  const auto layers = [&](const Volume<double>& values, const Volume<double>& fine,
                          const Volume<float>& deviation) {
    return layers_of(values, synthetic::average_volume(fine, data.grid), deviation, data.lit_face);
  };
  return {{"kappa", layers(fit.medium.kappa, fine_truth.kappa, found.log_kappa_std)},
          {"mu", layers(fit.medium.mu, fine_truth.mu, found.log_mu_std)}};
}

}  // namespace

void measure_coverage(const Request& request, Progress& progress, const Save& save) {
  const Block block = population_block(request.size);
  const GridShape fine = block.grid.refined(2);
  inverse::FitOptions options;
  options.path.model = inverse::Model::volume;
  options.uncertainty.probes = inverse::usual_probes;
  options.solver.backend.device = request.device;
  Json rows = Json::array();
  for (int s = 0; s < request.count("seeds", 1); ++s) {
    const std::uint64_t seed = request.seed + static_cast<std::uint64_t>(s);
    for (const auto& [name, family] : family_names) {
      progress.update("coverage", 0.0, name + std::string(", seed ") + std::to_string(seed));
      const inverse::CoefficientPair truth = make_family(fine, family, block.grid.voxel_mm, seed);
      const SurfaceMeasurements clean = expose(block, truth, bar_light(block.grid, block.lit, 8));
      for (const double noise : {0.003, 0.01, 0.03}) {
        SurfaceMeasurements data = clean;
        add_noise(data, noise, 1000 + seed);
        Json row{{"family", name}, {"seed", seed}, {"noise", noise}};
        row.update(fit_row(data, inverse::to_medium(truth, fine), options));
        rows.push_back(row);
      }
      save({{"rows", rows}});
      if (request.size == Size::quick) return;
    }
  }
}

}  // namespace kappamu::bench
