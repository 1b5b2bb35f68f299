#include "studies/inverse/coverage.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "data_synthetic/score.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_uncertainty.h"
#include "studies/inverse/ablations.h"
#include "tests/cases/inverse_case.h"
#include "tests/cases/media.h"
#include "tests/cases/population.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

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

Json fit_row(const SurfaceMeasurements& data, const Medium& fine_truth, const Block& block,
             const inverse::FitOptions& options) {
  Progress silent;
  const inverse::ChannelFit fit = inverse::fit_channel(data, 0, options, {}, silent, {}, {});
  const inverse::Uncertainty found = inverse::estimate_volume_uncertainty(
      fit, inverse::shared_deviation({&fit, 1}, data.lit_face), data);
  const Medium truth = resolved_truth(fine_truth, block, found.report.layers);
  return {{"kappa", layers_of(fit.medium.kappa, truth.kappa, found.log_kappa_std, block.lit)},
          {"mu", layers_of(fit.medium.mu, truth.mu, found.log_mu_std, block.lit)}};
}

}  // namespace

Medium resolved_truth(const Medium& fine, const Block& block,
                      const std::vector<inverse::LayerUncertainty>& layers) {
  std::vector<double> of_kappa, of_mu;
  for (const inverse::LayerUncertainty& layer : layers) {
    of_kappa.push_back(layer.kappa_fwhm_mm);
    of_mu.push_back(layer.mu_fwhm_mm);
  }
  const auto on_grid = [&](const Volume<double>& volume, const std::vector<double>& fwhm_mm) {
    return synthetic::resolved(synthetic::average_volume(volume, block.grid), block.seen, fwhm_mm);
  };
  return {on_grid(fine.kappa, of_kappa), on_grid(fine.mu, of_mu)};
}

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
        row.update(fit_row(data, inverse::to_medium(truth, fine), block, options));
        rows.push_back(row);
      }
      save({{"rows", rows}});
      if (request.size == Size::quick) return;
    }
  }
}

}  // namespace kappamu::studies
