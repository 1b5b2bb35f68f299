// The homogeneous block that a fit starts from, found without a guess: lit faces on which a coarse
// grid blurs the light that tells, thin blocks, and a population in which no place is lower than
// the one found.
#include "inverse/block_model/homogeneous.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/error.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using cases::Block;
using ::testing::HasSubstr;

CoefficientPair homogeneous(const GridShape& shape, double kappa, double mu) {
  return {std::vector<double>(shape.cells(), std::log(kappa)),
          std::vector<double>(shape.cells(), std::log(mu))};
}

/// `relative` noise of every value; lit pixels stay in.
void add_noise(SurfaceMeasurements& m, double relative, std::uint64_t seed) {
  test_cases::Noise noise(seed);
  for (std::size_t i = 0; i < m.value.size(); ++i) {
    const auto sigma = static_cast<float>(relative * m.value[i]);
    m.value[i] += sigma * static_cast<float>(noise.normal());
    m.variance[i] = sigma * sigma;
  }
}

enum class Light { sinusoid, bars, patches };

/// Even light, then two patterns of the kind; `period` in voxels.
std::vector<double> light_of(Light kind, FaceShape face, double period) {
  std::vector<double> light(face.cells(), 1.0);
  for (int m = 0; m < 2; ++m) {
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const double turn = (m == 0 ? u + 0.5 : v + 0.5) / period;
        const double wave = std::cos(2.0 * std::numbers::pi * turn);
        const bool patch = (u * 3 / face.nu + v * 3 / face.nv) % 2 == m;
        light.push_back(kind == Light::sinusoid ? 0.5 + 0.5 * wave
                        : kind == Light::bars   ? (wave > 0.0 ? 1.0 : 0.0)
                                                : (patch ? 1.0 : 0.0));
      }
    }
  }
  return light;
}

TEST(HomogeneousStart, OfALitFaceUnderASinusoidIsNotThatOfACoarseGrid) {
  Block block;
  block.grid = {40, 40, 12, 0.56};  // the coarsest grid has two voxels a period
  block.seen = block.lit;
  constexpr double kappa = 0.22, mu = 0.03, period_mm = 5.0;
  const FaceShape face = face_shape(block.grid, block.lit);
  std::vector<double> light = light_of(Light::sinusoid, face, period_mm / block.grid.voxel_mm);
  light.resize(2 * face.cells());
  SurfaceMeasurements m =
      test_cases::expose(block, homogeneous(block.grid.refined(2), kappa, mu), light);
  add_noise(m, 0.01, 7);
  FitOptions options;
  options.path.model = Model::homogeneous;
  const FitReport report = cases::fit(m, options).report;
  EXPECT_NEAR(report.homogeneous_kappa / kappa, 1.0, 0.02);
  EXPECT_NEAR(report.homogeneous_mu / mu, 1.0, 0.05);
}

struct StartCase {
  double kappa;
  double mu;
  double voxel_mm;
};
class HomogeneousStartOf : public ::testing::TestWithParam<StartCase> {};

TEST_P(HomogeneousStartOf, PatchesFromBehindIsFoundWithoutAGuess) {
  const StartCase& c = GetParam();
  Block block;
  block.grid.voxel_mm = c.voxel_mm;
  Problem problem =
      make_problem(cases::measure(block, homogeneous(block.grid.refined(2), c.kappa, c.mu)), 0,
                   forward::Convention::physical, {});
  HomogeneousFit fit = find_homogeneous(problem);
  EXPECT_TRUE(fit.converged);
  // The data's own grid has cells two thirds of a mean free path wide.
  constexpr double of_data = 0.08;
  EXPECT_NEAR(fit.kappa / c.kappa, 1.0, of_data);
  EXPECT_NEAR(fit.mu / c.mu, 1.0, of_data);

  const Refinement finer = refine(problem);
  Objective objective(std::move(problem), {});
  objective.refresh_correction(finer, homogeneous(block.grid, fit.kappa, fit.mu));
  const int before = objective.solves().total();
  fit = refit_homogeneous(objective, fit);
  constexpr int few_steps = 12;
  EXPECT_LT(objective.solves().total() - before, few_steps);
  EXPECT_TRUE(fit.converged);
  // Noise of 1 % on 4096 data moves the two parameters by far less.
  constexpr double two_percent = 0.02;
  EXPECT_NEAR(fit.kappa / c.kappa, 1.0, two_percent);
  EXPECT_NEAR(fit.mu / c.mu, 1.0, two_percent);
}

INSTANTIATE_TEST_SUITE_P(MarbleWaxMilk, HomogeneousStartOf,
                         ::testing::Values(StartCase{0.13, 0.01, 0.5}, StartCase{0.3, 0.1, 0.5},
                                           StartCase{0.6, 0.005, 2.0}));

/// Whether a descent from the truth ends lower than where the search ended.
class Population {
 public:
  explicit Population(std::uint64_t seed) : chance_(seed) {}

  /// Of a block drawn by chance: the search's residual over that of the descent from the truth.
  double search_over_truth(std::string& what) {
    Block block;
    double kappa = 0.0, mu = 0.0;
    do {
      kappa = drawn(0.05, 3.0);
      mu = drawn(1e-4, 0.3);
      block.grid = {16, 16, 4 + static_cast<int>(8.0 * chance_.uniform()), drawn(0.25, 1.5)};
    } while (!sensible(block.grid, kappa, mu));
    const auto kind = static_cast<Light>(static_cast<int>(3.0 * chance_.uniform()));
    if (chance_.uniform() < 0.5) block.seen = block.lit;
    const std::vector<double> light =
        light_of(kind, face_shape(block.grid, block.lit), 4.0 + 8.0 * chance_.uniform());
    SurfaceMeasurements m =
        test_cases::expose(block, homogeneous(block.grid.refined(2), kappa, mu), light);
    add_noise(m, 0.01, 1);
    const Problem problem = make_problem(m, 0, forward::Convention::physical, {});
    const HomogeneousFit found = find_homogeneous(problem);
    const HomogeneousFit right = find_homogeneous(problem, HomogeneousGuess{kappa, mu});
    char line[200];
    std::snprintf(line, sizeof line,
                  "%s, light %d, %d voxels of %.2g mm deep, kappa %.3g, mu %.3g: found %.3g, %.3g "
                  "(residual %.3g)",
                  block.seen == block.lit ? "front-lit" : "back-lit", static_cast<int>(kind),
                  block.grid.nz, block.grid.voxel_mm, kappa, mu, found.kappa, found.mu,
                  found.log_residual);
    what = line;
    return found.log_residual / right.log_residual;
  }

 private:
  double drawn(double least, double most) {
    return least * std::pow(most / least, chance_.uniform());
  }
  /// Scatters more than it absorbs, and lets a trace of light through.
  static bool sensible(const GridShape& shape, double kappa, double mu) {
    return 3.0 * kappa * mu < 0.5 && std::sqrt(mu / kappa) * shape.nz * shape.voxel_mm < 8.0;
  }
  test_cases::Noise chance_;
};

TEST(HomogeneousStart, IsTheLowestOfAllValleys) {
  Population population(1);
  constexpr int blocks = 40;
  for (int k = 0; k < blocks; ++k) {
    std::string what;
    const double ratio = population.search_over_truth(what);
    EXPECT_LT(ratio, 1.001) << k << ": " << what;
  }
}

TEST(HomogeneousStart, OfADarkChannelIsRefused) {
  const Block block;
  SurfaceMeasurements m = cases::measure(block, homogeneous(block.grid.refined(2), 0.2, 0.02));
  for (float& variance : m.variance) variance = 1.0F;
  try {
    find_homogeneous(make_problem(m, 0, forward::Convention::physical, {}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the channel is dark"));
  }
}

}  // namespace
}  // namespace kappamu::inverse
