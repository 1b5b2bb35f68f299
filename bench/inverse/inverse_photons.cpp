#include "bench/inverse/inverse_photons.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/cases/media.h"
#include "core/appearance_error.h"
#include "forward/montecarlo/monte_carlo_model.h"
#include "inverse/problem/predict.h"
#include "inverse/problem/problem.h"

namespace kappamu::bench {

namespace {

using inverse::CoefficientPair;

/// Exitance on the seen face by photons and its variance, means over the fitted surface voxels.
SurfaceMeasurements trace(const Block& block, const CoefficientPair& fine_fields,
                          const std::vector<double>& irradiance, const PhotonOptions& options,
                          std::uint64_t seed, Progress& progress) {
  SurfaceMeasurements m;
  m.grid = block.grid;
  m.lit_face = block.lit;
  m.seen_face = block.seen;
  m.channels = {"grey"};
  m.patterns = static_cast<int>(irradiance.size() / m.lit_shape().cells());
  m.irradiance.assign(irradiance.begin(), irradiance.end());
  forward::ForwardProblem problem;
  problem.setup = inverse::make_setup(m, forward::Convention::physical);
  problem.setup.shape = block.grid.refined(2);
  const GridShape& fine = problem.setup.shape;
  problem.medium = {Volume<double>(fine), Volume<double>(fine)};
  for (std::size_t i = 0; i < fine.cells(); ++i) {
    problem.medium.kappa[i] = std::exp(fine_fields.log_kappa[i]);
    problem.medium.mu[i] = std::exp(fine_fields.log_mu[i]);
  }
  problem.patterns = m.patterns;
  problem.irradiance =
      inverse::split_face(irradiance, m.lit_shape(), face_shape(fine, block.lit), 2, m.patterns);
  forward::ForwardOptions how;
  how.device = options.device;
  how.seed = seed;
  how.photons = options.per_pattern;
  const forward::ForwardResult result =
      forward::make_monte_carlo_model()->solve(problem, how, progress);
  const auto face = static_cast<std::size_t>(
      std::find(all_faces.begin(), all_faces.end(), block.seen) - all_faces.begin());
  const auto mean = [&](const std::vector<double>& values) {
    return inverse::restrict_face(values, face_shape(fine, block.seen), m.seen_shape(), 2,
                                  m.patterns);
  };
  std::vector<double> variance = result.standard_error[face];
  for (double& s : variance) s *= s;
  for (const double x : mean(result.exitance[face])) m.value.push_back(static_cast<float>(x));
  // Four pixels to a surface voxel: the variance of their mean is a quarter of their mean variance.
  for (const double x : mean(variance)) m.variance.push_back(static_cast<float>(0.25 * x));
  return m;
}

AppearanceError error_of(const std::vector<float>& predicted, const SurfaceMeasurements& photons) {
  AppearanceError error;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    error.add(predicted[i], photons.value[i], photons.variance[i]);
  }
  return error;
}

/// Some of the 8 × 8 patches, spread evenly.
std::vector<double> validation_light(const Block& block, int count) {
  const std::vector<double> all = patch_light(block.grid, block.lit, 64);
  const auto cells = static_cast<std::ptrdiff_t>(face_shape(block.grid, block.lit).cells());
  std::vector<double> light;
  for (int k = 0; k < count; ++k) {
    // Steps of 64 / count, shifted by a row's share so that they do not line up in columns.
    const std::ptrdiff_t m = (k * 64 / count + k % 8) % 64;
    light.insert(light.end(), all.begin() + m * cells, all.begin() + (m + 1) * cells);
  }
  return light;
}

}  // namespace

Json fit_monte_carlo(const Block& block, const CoefficientPair& fine_fields,
                     const inverse::FitOptions& fit, const PhotonOptions& options,
                     Progress& progress) {
  SurfaceMeasurements m = trace(block, fine_fields, patch_light(block.grid, block.lit, 16), options,
                                options.seed, progress);
  const std::vector<float> photons = m.variance;
  add_noise(m, options.noise, options.seed);
  for (std::size_t i = 0; i < m.variance.size(); ++i) m.variance[i] += photons[i];
  const SurfaceMeasurements validation =
      trace(block, fine_fields, validation_light(block, options.validation_patterns), options,
            options.seed + 1, progress);

  // The truth itself under diffusion, on the photons' own grid.
  SurfaceMeasurements fine = validation;
  fine.grid = block.grid.refined(2);
  const std::vector<double> light(validation.irradiance.begin(), validation.irradiance.end());
  const std::vector<double> split =
      inverse::split_face(light, validation.lit_shape(), fine.lit_shape(), 2, validation.patterns);
  fine.irradiance.assign(split.begin(), split.end());
  Medium truth{Volume<double>(fine.grid), Volume<double>(fine.grid)};
  for (std::size_t i = 0; i < fine.grid.cells(); ++i) {
    truth.kappa[i] = std::exp(fine_fields.log_kappa[i]);
    truth.mu[i] = std::exp(fine_fields.log_mu[i]);
  }
  const std::vector<float> predicted = inverse::predict(truth, fine, {});
  const std::vector<double> coarse =
      inverse::restrict_face({predicted.begin(), predicted.end()}, fine.seen_shape(),
                             validation.seen_shape(), 2, validation.patterns);
  const double truth_E = error_of({coarse.begin(), coarse.end()}, validation).denoised_E();

  const auto error_by_photons = [&](const Medium& medium) {
    const auto in_halves = [&](const Volume<double>& volume) {
      std::vector<double> values = inverse::split_voxels(volume.values(), block.grid, fine.grid, 2);
      for (double& x : values) x = std::log(x);
      return values;
    };
    const SurfaceMeasurements seen = trace(block, {in_halves(medium.kappa), in_halves(medium.mu)},
                                           light, options, options.seed + 3, progress);
    SurfaceMeasurements both = validation;
    for (std::size_t i = 0; i < both.variance.size(); ++i) both.variance[i] += seen.variance[i];
    return error_of(seen.value, both);
  };
  Json rows = Json::array();
  for (const inverse::Physics physics :
       {inverse::Physics::diffusion, inverse::Physics::transport}) {
    inverse::FitOptions by = fit;
    by.data.physics = physics;
    by.path.model = inverse::Model::volume;
    by.solver.seed = options.seed + 2;
    const inverse::ChannelFit found = inverse::fit_channel(m, 0, by, {}, progress);
    Json result = score_of(found, m, fine_fields);
    const AppearanceError fitted =
        physics == inverse::Physics::transport
            ? error_by_photons(found.medium)
            : error_of(inverse::predict(found.medium, validation, {}), validation);
    result["variant"] = physics == inverse::Physics::transport ? "transport" : "diffusion";
    result["noise"] = options.noise;
    result["photons"] = found.report.solves.photons;
    result["renewals"] = found.report.solves.refined;
    result["warnings"] = found.report.warnings;
    result["validation_E"] = fitted.denoised_E();
    result["photon_noise_E"] = fitted.noise_E();
    result["truth_E"] = truth_E;
    rows.push_back(result);
  }
  return rows;
}

}  // namespace kappamu::bench
