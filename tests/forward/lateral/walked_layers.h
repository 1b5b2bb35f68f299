// Reflectance of two layers by Monte Carlo through voxels (forward/montecarlo).
#pragma once

#include <cmath>
#include <numbers>

#include "core/optics.h"
#include "forward/forward_model.h"
#include "forward/lateral/lateral_reflectance.h"

namespace kappamu::test_cases {

inline constexpr double layers_index = 1.4, layers_g = 0.8;

/// Reflectance by Monte Carlo (forward/montecarlo) and its standard error: a block with mirrors for
/// sides, two sinusoids' periods wide, so deep that its far side is not felt.
struct Walked {
  double reflectance = 0.0, error = 0.0;
};
inline Walked walked(double frequency, const forward::LateralLayer& upper,
                     const forward::LateralLayer& lower, double thickness, std::uint64_t photons,
                     std::uint64_t seed = 1) {
  const double width = frequency > 0.0 ? 2.0 / frequency : 4.0;  // [mm]
  // Voxels are cubes, so many over the thickness that a whole number of them, 32 or more, is as
  // wide as the block: layers stretched along the depth alone spread light aside differently.
  constexpr double fewest_columns = 32.0, whole = 1e-9;
  int above = std::max(1, static_cast<int>(std::ceil(fewest_columns * thickness / width - whole)));
  while (std::abs(std::remainder(width * above / thickness, 1.0)) > whole) ++above;
  const double voxel = thickness / above;
  const int columns = static_cast<int>(std::lround(width / voxel));
  const int depth = above + static_cast<int>(std::ceil(25.0 / (lower.musp * voxel)));
  forward::ForwardProblem problem;
  problem.setup.shape = {columns, 2, depth, voxel};
  problem.setup.eta = layers_index;
  problem.setup.lit_face = Face::z_minus;
  problem.setup.sides = Sides::mirror;
  problem.medium = {Volume<double>(problem.setup.shape), Volume<double>(problem.setup.shape)};
  for (int z = 0; z < depth; ++z) {
    const forward::LateralLayer& of = z < above ? upper : lower;
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < columns; ++x) {
        problem.medium.mu(x, y, z) = of.mua;
        problem.medium.kappa(x, y, z) = 1.0 / (3.0 * (of.mua + of.musp));
      }
    }
  }
  // Light is the sinusoid's mean in each voxel, and constant there: its fundamental has the factor
  // sinc twice, and the voxels' means of what comes back have it a third time.
  const double half = std::numbers::pi * frequency * voxel;
  const double sinc = half > 0.0 ? std::sin(half) / half : 1.0;
  const auto wave = [&](int x) {  // mean over the pixel
    return sinc * std::cos(2.0 * std::numbers::pi * frequency * voxel * (x + 0.5));
  };
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < columns; ++x) {
      problem.irradiance.push_back(frequency > 0.0 ? 1.0 + wave(x) : 1.0);
    }
  }
  forward::ForwardOptions options;
  options.photons = photons;
  options.seed = seed;
  options.anisotropy = layers_g;
  options.device = "auto";
  Progress quiet;
  const forward::ForwardResult result =
      forward::make_forward_model("montecarlo")->solve(problem, options, quiet);
  const auto& out = result.exitance[static_cast<std::size_t>(Face::z_minus)];
  const auto& error = result.standard_error[static_cast<std::size_t>(Face::z_minus)];
  double sum = 0.0, norm = 0.0, variance = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double weight = frequency > 0.0 ? wave(static_cast<int>(i) % columns) : 1.0;
    sum += weight * out[i];
    norm += weight * weight;
    variance += weight * weight * error[i] * error[i];
  }
  const double entered =
      boundary_constants(layers_index).normal_transmittance * (frequency > 0.0 ? sinc * sinc : 1.0);
  return {sum / (norm * entered), std::sqrt(variance) / (norm * entered)};
}

}  // namespace kappamu::test_cases
