// Media, light and measurements the tests of the inverse problem share.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/grid.h"
#include "core/surface_measurements.h"
#include "forward/operator.h"
#include "inverse/problem/fields.h"
#include "inverse/problem/objective.h"
#include "inverse/problem/problem.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::inverse::cases {

using test_cases::Noise;

inline CoefficientPair random_direction(const GridShape& shape, std::uint64_t seed) {
  Noise noise(seed);
  CoefficientPair pair{std::vector<double>(shape.cells()), std::vector<double>(shape.cells())};
  for (double& x : pair.log_kappa) x = noise.normal();
  for (double& x : pair.log_mu) x = noise.normal();
  return pair;
}

/// κ about 0.15 mm and μ about 0.05 1/mm, varying from voxel to voxel by `contrast` (log units).
inline CoefficientPair rough_medium(const GridShape& shape, double contrast, std::uint64_t seed) {
  CoefficientPair fields = random_direction(shape, seed);
  for (double& x : fields.log_kappa) x = std::log(0.15) + contrast * x;
  for (double& x : fields.log_mu) x = std::log(0.05) + contrast * x;
  return fields;
}

/// Smooth fields with an absorbing box, as a function of position relative to the block.
inline CoefficientPair smooth_medium(const GridShape& shape) {
  CoefficientPair fields{std::vector<double>(shape.cells()), std::vector<double>(shape.cells())};
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const double a = (x + 0.5) / shape.nx;
        const double b = (y + 0.5) / shape.ny;
        const double c = (z + 0.5) / shape.nz;
        const bool box = a > 0.25 && a < 0.5 && b > 0.5 && b < 0.75 && c > 0.25;
        const std::size_t i = shape.index(x, y, z);
        fields.log_kappa[i] = std::log(0.2) + 0.5 * std::sin(5.0 * a + 1.0) * std::cos(4.0 * b);
        fields.log_mu[i] =
            std::log(0.02) + 0.4 * std::cos(4.0 * a - 3.0 * b + c) + (box ? 0.8 : 0.0);
      }
    }
  }
  return fields;
}

/// A block under random light on every pixel of one face, seen from the other; without data.
inline Problem randomly_lit(const GridShape& shape, int patterns, Noise& noise) {
  Problem problem;
  problem.setup = {shape,
                   1.3,
                   Face::z_minus,
                   Sides::open,
                   forward::SourceModel::first_collision,
                   forward::Convention::physical};
  problem.seen_face = Face::z_plus;
  problem.patterns = patterns;
  problem.irradiance.resize(static_cast<std::size_t>(patterns) * problem.lit_shape().cells());
  for (double& e : problem.irradiance) e = noise.uniform();
  return problem;
}

/// Noise-free exitance under `light`, [patterns][v][u].
inline std::vector<double> simulate(const forward::GridSetup& setup, const CoefficientPair& fields,
                                    Face seen, const std::vector<double>& light, int patterns,
                                    const std::string& device) {
  const auto op = forward::block_operators()
                      ->make(setup, seen, device, forward::Precision::double_precision)
                      .op;
  op->set_medium(exponential(fields.log_kappa), exponential(fields.log_mu));
  return solve_exitance(*op, light, patterns, {16, {1e-9, 1000}});
}

}  // namespace kappamu::inverse::cases
