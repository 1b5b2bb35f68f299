// The model `analytic` against the grid solver that knows nothing of it: patch light on a layered
// block, where the grid's answer must converge to the closed form at order 2.
#include "forward/analytic/layered_block.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "tests/forward/grid/test_tools.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

using testing::Values;

constexpr double rounding = 1e-11;

/// 8 × 6 pixels of 0.5 mm, 2 mm deep; two layers of 1 mm.
ForwardProblem block(int per_pixel, Face lit, SourceModel source) {
  ForwardProblem problem;
  problem.setup.lit_face = lit;
  problem.setup.sides = Sides::mirror;
  problem.setup.source = source;
  const GridShape coarse = lit == Face::z_minus ? GridShape{8, 6, 4, 0.5} : GridShape{4, 8, 6, 0.5};
  problem.setup.shape = coarse.refined(per_pixel);
  const GridShape& s = problem.setup.shape;
  problem.medium = {Volume<double>(s), Volume<double>(s)};
  const FaceShape face = face_shape(s, lit);
  const int depth = s.extent(axis_of(lit));
  for (int w = 0; w < depth; ++w) {
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const std::size_t i = face_cell(s, lit, u, v, w);
        const bool upper = 2 * w < depth;
        problem.medium.kappa[i] = upper ? 0.25 : 0.4;
        problem.medium.mu[i] = upper ? 0.02 : 0.1;
      }
    }
  }
  problem.patterns = 2;
  for (int m = 0; m < 2; ++m) {
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const int x = u / per_pixel, y = v / per_pixel;
        const bool bright = m == 0 ? x >= 2 && x < 5 && y < 3 : x == 6 && y == 4;
        problem.irradiance.push_back(bright ? 1.0 : 0.0);
      }
    }
  }
  return problem;
}

Values pixel_means(const Values& map, FaceShape fine, int per_pixel) {
  const int width = fine.nu / per_pixel, height = fine.nv / per_pixel;
  const std::size_t patterns = map.size() / fine.cells();
  Values means(patterns * static_cast<std::size_t>(width * height), 0.0);
  for (std::size_t m = 0; m < patterns; ++m) {
    for (int v = 0; v < fine.nv; ++v) {
      for (int u = 0; u < fine.nu; ++u) {
        means[(m * height + v / per_pixel) * width + u / per_pixel] +=
            map[(m * fine.nv + v) * fine.nu + u] / (per_pixel * per_pixel);
      }
    }
  }
  return means;
}

ForwardResult answer(const std::string& method, const ForwardProblem& problem) {
  ForwardOptions options;
  options.precision = Precision::double_precision;
  options.solve = {1e-11, 500};
  Progress silent;
  return make_forward_model(method)->solve(problem, options, silent);
}

TEST(AnalyticModel, IsWhatTheGridConvergesTo) {
  // The grid's slope at these sizes, not yet asymptotic; the first collisions' mean free path is
  // 0.75 mm, that of the coarsest voxels 0.25 mm.
  constexpr double order = 2.0, order_band = 0.25;
  for (const Face lit : {Face::z_minus, Face::x_plus}) {
    const ForwardResult exact = answer("analytic", block(1, lit, SourceModel::first_collision));
    for (const Face face : {lit, opposite(lit)}) {
      const auto f = static_cast<std::size_t>(face);
      Values errors;
      for (const int n : {2, 4, 8}) {
        const ForwardProblem problem = block(n, lit, SourceModel::first_collision);
        const ForwardResult grid = answer("reference", problem);
        errors.push_back(testing::relative_difference(
            pixel_means(grid.exitance[f], face_shape(problem.setup.shape, face), n),
            exact.exitance[f]));
      }
      for (std::size_t i = 1; i < errors.size(); ++i) {
        EXPECT_NEAR(std::log2(errors[i - 1] / errors[i]), order, order_band)
            << to_string(lit) << " lit, " << to_string(face) << " seen: " << errors[i - 1]
            << " then " << errors[i];
      }
    }
  }
}

/// Under the boundary source the lit face's map converges slowly (docs/theory.md), the far one at
/// order 2.
TEST(AnalyticModel, IsWhatTheGridConvergesToUnderDiffuseLight) {
  const ForwardResult exact = answer("analytic", block(1, Face::z_minus, SourceModel::boundary));
  Values near, far;
  for (const int n : {2, 4, 8}) {
    const ForwardProblem problem = block(n, Face::z_minus, SourceModel::boundary);
    const ForwardResult grid = answer("reference", problem);
    const FaceShape face = face_shape(problem.setup.shape, Face::z_minus);
    near.push_back(
        testing::relative_difference(pixel_means(grid.exitance[4], face, n), exact.exitance[4]));
    far.push_back(
        testing::relative_difference(pixel_means(grid.exitance[5], face, n), exact.exitance[5]));
  }
  for (std::size_t i = 1; i < near.size(); ++i) {
    EXPECT_GT(std::log2(near[i - 1] / near[i]), 0.9) << near[i - 1] << " then " << near[i];
    EXPECT_NEAR(std::log2(far[i - 1] / far[i]), 2.0, 0.25) << far[i - 1] << " then " << far[i];
  }
}

/// Cutting every pixel in two changes neither light nor medium: what remains is the cut of the
/// series, the error layered_block.h states.
TEST(AnalyticModel, DoesNotDependOnThePixelsItIsAskedIn) {
  const ForwardProblem fine = block(2, Face::z_minus, SourceModel::first_collision);
  const ForwardResult a = answer("analytic", block(1, Face::z_minus, SourceModel::first_collision));
  const ForwardResult b = answer("analytic", fine);
  const FaceShape face = face_shape(fine.setup.shape, Face::z_minus);
  constexpr double series_cut = 1e-5, far_series_cut = 1e-7;
  const double near =
      testing::relative_difference(pixel_means(b.exitance[4], face, 2), a.exitance[4]);
  EXPECT_LT(near, series_cut);
  RecordProperty("lit_face", std::to_string(near));
  EXPECT_LT(testing::relative_difference(pixel_means(b.exitance[5], face, 2), a.exitance[5]),
            far_series_cut);
}

TEST(AnalyticModel, EvenLightIsTheStackAndPowerBalances) {
  ForwardProblem problem = block(1, Face::z_minus, SourceModel::first_collision);
  problem.irradiance.assign(problem.irradiance.size(), 0.7);
  const ForwardResult result = answer("analytic", problem);
  const BoundaryConstants constants = boundary_constants(problem.setup.eta);
  const std::vector<Layer> layers{{0.25, 0.02, 1.0}, {0.4, 0.1, 1.0}};
  const double T = constants.normal_transmittance;
  const LayeredMode mode(layers, constants.A, {0.0, 0.7 * T, 0.0, 1.0 - T});
  for (const double m : result.exitance[4]) EXPECT_NEAR(m, mode.flux_out_near(), rounding);
  for (const double m : result.exitance[5]) EXPECT_NEAR(m, mode.flux_out_far(), rounding);
  for (const double m : result.exitance[0]) EXPECT_EQ(m, 0.0);
  const PowerBalance& b = result.balance.front();
  const double area = 8 * 6 * 0.25;
  EXPECT_NEAR(b.unscattered, area * (mode.unscattered_near() + mode.unscattered_far()), rounding);
  const ForwardResult grid = answer("reference", problem);
  EXPECT_NEAR(b.absorbed, grid.balance.front().absorbed, 0.02 * b.absorbed);  // coarse grid
}

TEST(AnalyticModel, SaysWhatItCannotAnswer) {
  const auto sentence = [](const ForwardProblem& problem) {
    return sentence_of([&] { answer("analytic", problem); });
  };
  ForwardProblem open = block(1, Face::z_minus, SourceModel::first_collision);
  open.setup.sides = Sides::open;
  EXPECT_THAT(sentence(open), ::testing::HasSubstr("mirror sides"));
  ForwardProblem varied = block(1, Face::x_plus, SourceModel::first_collision);
  varied.medium.mu[varied.setup.shape.index(1, 3, 2)] *= 1.01;
  EXPECT_THAT(sentence(varied),
              ::testing::HasSubstr("mu varies across it in layer 2 below face x+"));
}

}  // namespace
}  // namespace kappamu::forward
