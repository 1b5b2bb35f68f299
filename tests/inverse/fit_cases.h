// Measurements of a made-up block for the tests of the fit: data on a grid twice as fine as the
// fitted one, with noise, and the score under light the fit never saw.
#pragma once

#include <cmath>
#include <vector>

#include "inverse/fit.h"
#include "inverse/predict.h"
#include "inverse/problem.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse::cases {

struct Block {
  GridShape grid{16, 16, 6, 0.5};
  Face lit = Face::z_minus;
  Face seen = Face::z_plus;
  Light light = Light::collimated;
  Quantity quantity = Quantity::exitance;
  double noise = 0.01;  ///< σ = noise (value + noise · pattern's maximum)
};

/// Noise-free values under `side`² patches, solved with every voxel split in 2³.
inline SurfaceMeasurements expose(const Block& block, const CoefficientPair& fine_fields,
                                  int side) {
  SurfaceMeasurements m;
  m.grid = block.grid;
  m.lit_face = block.lit;
  m.seen_face = block.seen;
  m.light = block.light;
  m.quantity = block.quantity;
  m.channels = {"grey"};
  m.patterns = side * side;
  m.irradiance = patch_light(m.lit_shape(), side);
  const forward::GridSetup setup = make_setup(m, forward::Convention::physical);
  forward::GridSetup fine = setup;
  fine.shape = setup.shape.refined(2);
  const FaceShape fine_seen = face_shape(fine.shape, block.seen);
  const std::vector<double> light =
      split_face({m.irradiance.begin(), m.irradiance.end()}, m.lit_shape(),
                 face_shape(fine.shape, block.lit), 2, m.patterns);
  const std::vector<double> exitance =
      restrict_face(simulate(fine, fine_fields, block.seen, light, m.patterns, "auto"), fine_seen,
                    m.seen_shape(), 2, m.patterns);
  const double scale = 1.0 / exitance_per_value(m, setup);
  for (const double x : exitance) m.value.push_back(static_cast<float>(scale * x));
  m.variance.assign(m.value.size(), 1.0F);
  return m;
}

/// Adds Gaussian noise and states its variance; front-lit pixels are masked.
inline SurfaceMeasurements measure(const Block& block, const CoefficientPair& fine_fields,
                                   int side = 4) {
  SurfaceMeasurements m = expose(block, fine_fields, side);
  Noise noise(7);
  const std::size_t cells = m.seen_shape().cells();
  if (block.lit == block.seen) m.mask.assign(m.value.size(), 1);
  for (std::size_t p = 0; p < static_cast<std::size_t>(m.patterns); ++p) {
    float largest = 0.0F;
    for (std::size_t i = p * cells; i < (p + 1) * cells; ++i) {
      const bool lit = block.lit == block.seen && m.irradiance[i] > 0.0F;
      if (lit) m.mask[i] = 0;
      if (!lit) largest = std::max(largest, m.value[i]);
    }
    for (std::size_t i = p * cells; i < (p + 1) * cells; ++i) {
      const double sigma = block.noise * (m.value[i] + block.noise * largest);
      m.value[i] += static_cast<float>(sigma * noise.normal());
      m.variance[i] = static_cast<float>(sigma * sigma);
    }
  }
  return m;
}

/// Σ(L' − L)²/ΣL² under 8 × 8 patches, the volume split in 2³; front-lit: where no light falls.
inline double held_out_error(const Block& block, const CoefficientPair& fine_fields,
                             const Medium& medium) {
  const SurfaceMeasurements truth = expose(block, fine_fields, 8);
  const std::vector<float> predicted = predict(medium, truth, {});
  double misfit = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    if (block.lit == block.seen && truth.irradiance[i] > 0.0F) continue;
    misfit += std::pow(predicted[i] - truth.value[i], 2);
    squares += std::pow(truth.value[i], 2);
  }
  return misfit / squares;
}

inline ChannelFit fit(const SurfaceMeasurements& measurements, const FitOptions& options,
                      const Checkpoint& checkpoint = {}) {
  Progress silent;
  return fit_channel(measurements, 0, options, checkpoint, silent);
}

}  // namespace kappamu::inverse::cases
