#include "tests/cases/limit_inverse_case.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "forward/montecarlo/monte_carlo_model.h"
#include "inverse/problem/objective.h"
#include "inverse/problem/problem.h"
#include "tests/cases/media.h"

namespace kappamu::test_cases {

namespace {

/// Nothing seen yet.
SurfaceMeasurements light_up(const Block& block, const std::vector<double>& light, double eta) {
  SurfaceMeasurements m;
  m.grid = block.grid;
  m.eta = eta;
  m.lit_face = block.lit;
  m.seen_face = block.seen;
  m.channels = {"grey"};
  m.patterns = static_cast<int>(light.size() / face_shape(block.grid, block.lit).cells());
  m.irradiance.assign(light.begin(), light.end());
  return m;
}

}  // namespace

inverse::CoefficientPair on_grid(const GridShape& shape, const Figure3& figure) {
  inverse::CoefficientPair fields;
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const Material m = figure((x + 0.5) / shape.nx, (y + 0.5) / shape.ny, (z + 0.5) / shape.nz);
        fields.log_kappa.push_back(m.log_kappa);
        fields.log_mu.push_back(m.log_mu);
      }
    }
  }
  return fields;
}

Figure3 even_block(double kappa, double mu) {
  return [=](double, double, double) { return Material{std::log(kappa), std::log(mu)}; };
}

Figure3 layered_block(double kappa, double mu) {
  return [=](double, double, double c) {
    const double k = c < 0.2 ? 0.6 : c < 0.5 ? -0.5 : c < 0.8 ? 0.2 : -0.3;
    const double m = c < 0.2 ? -0.7 : c < 0.5 ? 0.6 : c < 0.8 ? -0.2 : 0.4;
    return Material{std::log(kappa) + k, std::log(mu) + m};
  };
}

Figure3 random_layers(double kappa, double mu, std::uint64_t seed) {
  Noise noise(seed + 500);
  std::vector<double> change(8);
  for (double& x : change) x = 0.4 * noise.normal();
  return [=](double, double, double c) {
    const auto layer = static_cast<std::size_t>(std::clamp(4.0 * c, 0.0, 3.0));
    return Material{std::log(kappa) + change[layer], std::log(mu) + change[4 + layer]};
  };
}

Figure3 structured_block(double kappa, double mu, double strength, std::uint64_t seed) {
  Noise noise(seed + 100);
  std::vector<double> at(9);
  for (double& x : at) x = noise.uniform();
  return [=](double a, double b, double c) {
    const auto ball = [&](double x, double y, double z, double radius) {
      return std::exp(-std::pow(std::hypot(a - x, b - y, 0.4 * (c - z)) / radius, 4));
    };
    const double wave = std::sin(5.0 * a + 6.28 * at[0]) * std::cos(4.0 * b + 6.28 * at[1]);
    const double other = std::cos(4.0 * a - 3.0 * b + c + 6.28 * at[2]);
    const double one = ball(0.2 + 0.6 * at[3], 0.2 + 0.6 * at[4], at[5], 0.15);
    const double two = ball(0.2 + 0.6 * at[6], 0.2 + 0.6 * at[7], at[8], 0.2);
    return Material{std::log(kappa) + strength * (0.5 * wave + 0.7 * one - 0.5 * two),
                    std::log(mu) + strength * (0.5 * other + 1.0 * two - 0.4 * one)};
  };
}

Figure3 inclusions(double kappa, double mu, double contrast) {
  return [=](double a, double b, double c) {
    const bool low = std::hypot(a - 0.3, b - 0.35, c - 0.5) < 0.17;
    const bool high = std::hypot(a - 0.7, b - 0.65, c - 0.5) < 0.17;
    const double change = (high ? 1.0 : 0.0) - (low ? 1.0 : 0.0);
    return Material{std::log(kappa) + change * std::log(contrast), std::log(mu)};
  };
}

SurfaceMeasurements expose_figure(const Block& block, const Figure3& figure,
                                  const std::vector<double>& light, int factor, double eta) {
  SurfaceMeasurements m = light_up(block, light, eta);
  forward::GridSetup fine = inverse::make_setup(m, forward::Convention::physical);
  fine.shape = block.grid.refined(factor);
  const auto op = forward::block_operators()
                      ->make(fine, block.seen, "auto", forward::Precision::double_precision)
                      .op;
  const inverse::CoefficientPair fields = on_grid(fine.shape, figure);
  op->set_medium(inverse::exponential(fields.log_kappa), inverse::exponential(fields.log_mu));
  const std::vector<double> exitance = inverse::restrict_face(
      inverse::solve_exitance(
          *op,
          inverse::split_face(light, m.lit_shape(), face_shape(fine.shape, block.lit), factor,
                              m.patterns),
          m.patterns, {16, {1e-9, 1000}}),
      face_shape(fine.shape, block.seen), m.seen_shape(), factor, m.patterns);
  m.value.assign(exitance.begin(), exitance.end());
  m.variance.assign(m.value.size(), 1.0F);
  return m;
}

SurfaceMeasurements expose_figure(const Block& block, const Figure3& figure, int side, int factor,
                                  double eta) {
  return expose_figure(block, figure, patch_light(block.grid, block.lit, side * side), factor, eta);
}

SurfaceMeasurements expose_photons(const Block& block, const Figure3& figure, int side,
                                   std::uint64_t seed, double anisotropy) {
  constexpr std::uint64_t photons = 400'000;  // a pattern
  constexpr double unknown_noise = 0.25;      // standard error over value; 16 photons
  SurfaceMeasurements m = light_up(block, patch_light(block.grid, block.lit, side * side), 1.3);
  const inverse::CoefficientPair fields = on_grid(block.grid, figure);
  forward::ForwardProblem problem;
  problem.setup = inverse::make_setup(m, forward::Convention::physical);
  problem.medium = {Volume<double>(block.grid, inverse::exponential(fields.log_kappa)),
                    Volume<double>(block.grid, inverse::exponential(fields.log_mu))};
  problem.patterns = m.patterns;
  problem.irradiance.assign(m.irradiance.begin(), m.irradiance.end());
  forward::ForwardOptions how;
  how.seed = seed;
  how.photons = photons;
  how.anisotropy = anisotropy;
  Progress silent;
  const auto trace = [&] { return forward::make_monte_carlo_model()->solve(problem, how, silent); };
  const forward::ForwardResult result = trace();
  // Deviations and mask are those of photons of their own: a pixel that few photons reach would
  // else count for more, the fewer they happen to be.
  how.seed = ~seed;
  const forward::ForwardResult other = trace();
  const auto face = static_cast<std::size_t>(
      std::find(all_faces.begin(), all_faces.end(), block.seen) - all_faces.begin());
  for (std::size_t i = 0; i < result.exitance[face].size(); ++i) {
    const double error = other.standard_error[face][i];
    m.value.push_back(static_cast<float>(result.exitance[face][i]));
    m.variance.push_back(static_cast<float>(error * error));
    m.mask.push_back(error < unknown_noise * other.exitance[face][i] ? 1 : 0);
  }
  return m;
}

void spoil(SurfaceMeasurements& m, double relative, const Mistake& mistake, std::uint64_t seed) {
  if (mistake.stated_eta > 0.0) m.eta = mistake.stated_eta;
  const FaceShape face = m.seen_shape();
  const std::vector<float> clean = m.value;
  std::size_t row = 0;
  for (int line = 0; line < m.patterns * face.nv;
       ++line, row += static_cast<std::size_t>(face.nu)) {
    for (int u = 0; u < face.nu; ++u) {
      // Linear between pixels, constant beyond them.
      const double from = std::clamp(u - mistake.shift, 0.0, face.nu - 1.0);
      const int left = std::min(static_cast<int>(from), face.nu - 2);
      const float* pixel = &clean[row + static_cast<std::size_t>(left)];
      m.value[row + static_cast<std::size_t>(u)] =
          static_cast<float>(mistake.scale * std::lerp(pixel[0], pixel[1], from - left));
    }
  }
  add_noise(m, relative, seed);
  for (float& variance : m.variance) variance *= static_cast<float>(mistake.variance);
  if (mistake.outliers <= 0.0) return;
  Noise chance(seed + 1);
  const float largest = *std::max_element(m.value.begin(), m.value.end());
  for (float& value : m.value) {
    if (chance.uniform() < mistake.outliers) value = static_cast<float>(largest * chance.uniform());
  }
}

}  // namespace kappamu::test_cases
