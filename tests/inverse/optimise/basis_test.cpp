// Laws of the coordinates, the regulariser, the grid ladder and the sensitivity estimate.
#include "inverse/optimise/basis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/error.h"
#include "core/numbers/dot.h"
#include "core/numbers/relative_difference.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/problem/problem.h"
#include "inverse/regulariser/roughness.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

class BasisLaws : public ::testing::TestWithParam<int> {};

TEST_P(BasisLaws, InverseAndTranspose) {
  const GridShape shape{7, 5, 4, 0.3};
  const int axis = GetParam();
  const LateralModes modes({shape, axis});
  cases::Noise noise(3);
  LateralBlocks blocks;
  for (int bin = 0; bin < modes.bins(); ++bin) {
    Eigen::MatrixXd m(modes.rows(), modes.rows());
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = noise.normal();
    blocks.emplace_back(m * m.transpose());
  }
  constexpr double rounding = 1e-9;  // the random blocks' condition
  for (const Coordinates c : {Coordinates::voxels, Coordinates::smooth, Coordinates::informed}) {
    const Basis basis({shape, axis, 1.2}, {c, 1.2, 10.0}, blocks);
    const CoefficientPair u = cases::random_direction(shape, 1);
    const CoefficientPair w = cases::random_direction(shape, 2);
    const Vector z = basis.from_fields(u);
    const CoefficientPair back = basis.to_fields(z);
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      EXPECT_NEAR(back.log_kappa[i], u.log_kappa[i], rounding);
      EXPECT_NEAR(back.log_mu[i], u.log_mu[i], rounding);
    }
    // ⟨B z, w⟩ = ⟨z, Bᵀ w⟩
    const double left = dot(u.log_kappa, w.log_kappa) + dot(u.log_mu, w.log_mu);
    const Vector by_z = basis.gradient(w);
    EXPECT_NEAR(dot(z, by_z), left, rounding * shape.cells());
    const CoefficientPair by_field = basis.gradient_by_field(by_z);
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      EXPECT_NEAR(by_field.log_kappa[i], w.log_kappa[i], rounding);
      EXPECT_NEAR(by_field.log_mu[i], w.log_mu[i], rounding);
    }
  }
}

TEST_P(BasisLaws, CarriedIsByWayOfTheFields) {
  const MediumSpace space{{7, 5, 4, 0.3}, GetParam(), 1.2};
  const CoefficientPair u = cases::random_direction(space.shape, 4);
  for (const Coordinates c : {Coordinates::voxels, Coordinates::smooth}) {
    const Basis before(space, {c, 1.2, 10.0}, {}), after(space, {c, 0.7, 2.0}, {});
    const Vector z = before.from_fields(u), by_z = before.gradient(u);
    EXPECT_LT(relative_difference(after.carried(before, z), after.from_fields(u)), 1e-12);
    EXPECT_LT(relative_difference(after.carried_gradient(before, by_z), after.gradient(u)), 1e-12);
  }
  const Basis voxels(space, {Coordinates::voxels}, {}), smooth(space, {Coordinates::smooth}, {});
  EXPECT_THROW(smooth.carried(voxels, smooth.from_fields(u)), InternalError);
}
INSTANTIATE_TEST_SUITE_P(EveryDepthAxis, BasisLaws, ::testing::Values(0, 1, 2));

TEST(CosineTransform, IsTheMatrixOfItsDefinitionAtAnyLength) {
  for (const int n : {1, 2, 3, 6, 7, 16, 20, 53, 64, 130, 256}) {
    const CosineTransform transform(n);
    Eigen::MatrixXd expected(n, n);
    for (int k = 0; k < n; ++k) {
      for (int i = 0; i < n; ++i) {
        expected(k, i) =
            std::sqrt((k == 0 ? 1.0 : 2.0) / n) * std::cos(std::numbers::pi * k * (i + 0.5) / n);
      }
    }
    const Eigen::MatrixXd found = transform.forward(Eigen::MatrixXd::Identity(n, n));
    constexpr double rounding = 1e-13;
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), rounding) << n;
    EXPECT_LT((transform.inverse(found) - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(),
              rounding)
        << n;
  }
}

TEST(Roughness, DoesNotDependOnGridOrUnitOfLength) {
  const GridShape grid{24, 24, 8, 0.5};
  const double value = roughness({grid, 2, 4.0}, cases::smooth_medium(grid)).value;
  const GridShape metres{24, 24, 8, 0.5e-3};
  EXPECT_NEAR(roughness({metres, 2, 4.0e-3}, cases::smooth_medium(metres)).value, value,
              1e-12 * value);
  // A linear ramp along x: ∫|∇u|² dV / ℓ is known.
  for (const int n : {16, 32, 64}) {
    const GridShape shape{n, 4, 4, 8.0 / n};
    CoefficientPair ramp{std::vector<double>(shape.cells()), std::vector<double>(shape.cells())};
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      ramp.log_kappa[i] = 0.1 * static_cast<double>(i % n) * shape.voxel_mm;
    }
    const double area = 16.0 * shape.voxel_mm * shape.voxel_mm;
    const double exact = 0.5 * 0.01 * area * (8.0 - shape.voxel_mm) / 2.0;
    EXPECT_NEAR(roughness({shape, 2, 2.0}, ramp).value, exact, 1e-12);
  }
}

TEST(Roughness, AnchorAddsItsPullAlone) {
  const GridShape grid{4, 3, 5, 0.5};
  const CoefficientPair fields = cases::smooth_medium(grid);
  const Anchor anchor{-2.0, -4.0, 3.0};
  const Roughness plain = roughness({grid, 2, 2.5}, fields);
  const Roughness anchored = roughness({grid, 2, 2.5}, fields, anchor);
  double sum = 0.0;  // ½ ∫ |v − v*|² dV/(ℓ L²), v = log κ, log μ / 3
  for (std::size_t i = 0; i < grid.cells(); ++i) {
    sum += std::pow(fields.log_kappa[i] + 2.0, 2) +
           std::pow((fields.log_mu[i] + 4.0) / absorbers_vary, 2);
  }
  const double expected = 0.5 * std::pow(0.5, 3) * sum / (2.5 * 9.0);
  EXPECT_NEAR(anchored.value - plain.value, expected, 1e-12 * expected);
  // The gradient is that of the value: exact central differences of a quadratic.
  constexpr double step = 1e-3;
  for (const std::size_t i : {std::size_t{0}, std::size_t{17}}) {
    CoefficientPair up = fields;
    CoefficientPair down = fields;
    up.log_mu[i] += step;
    down.log_mu[i] -= step;
    const double slope = (roughness({grid, 2, 2.5}, up, anchor).value -
                          roughness({grid, 2, 2.5}, down, anchor).value) /
                         (2.0 * step);
    EXPECT_NEAR(anchored.gradient.log_mu[i], slope, 1e-8);
  }
}

TEST(Ladder, CoarseGridsKeepThePowerOfOddSizedLight) {
  cases::Block block;
  block.grid = {9, 7, 5, 0.5};
  SurfaceMeasurements m = cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2);
  m.mask.assign(m.value.size(), 1);
  m.mask[0] = 0;
  const Problem fine = make_problem(m, 0, forward::Convention::physical, {});
  const Problem coarse = coarsen(fine, {});
  EXPECT_EQ(coarse.setup.shape, (GridShape{5, 4, 3, 1.0}));
  const auto power = [](const Problem& p) {
    return std::accumulate(p.irradiance.begin(), p.irradiance.end(), 0.0) * p.setup.shape.voxel_mm *
           p.setup.shape.voxel_mm;
  };
  EXPECT_NEAR(power(coarse), power(fine), 1e-9);
  EXPECT_EQ(coarse.weight[0], 0.0) << "a coarse datum with a masked part is no mean";
  EXPECT_EQ(coarse.used(), coarse.data.size() - 1);
}

TEST(Sensitivity, EstimatesTheDiagonalOfTheNormalMatrix) {
  cases::Block block;
  block.grid = {5, 4, 3, 0.5};
  const SurfaceMeasurements m =
      cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 1);
  Objective objective(make_problem(m, 0, forward::Convention::physical, {}),
                      {"reference", forward::Precision::double_precision, {1e-10, 500}, 16, 64.0});
  objective.value(cases::smooth_medium(block.grid));
  std::vector<double> exact(block.grid.cells(), 0.0);
  std::vector<double> unit(objective.problem().data.size(), 0.0);
  for (double& one : unit) {
    one = 1.0;
    const CoefficientPair row = objective.jacobian_transpose(unit);
    for (std::size_t i = 0; i < exact.size(); ++i) exact[i] += row.log_mu[i] * row.log_mu[i];
    one = 0.0;
  }
  constexpr int probes = 400;
  const CoefficientPair estimate = estimate_sensitivity(random_rows(objective, probes, 1));
  const double five_sigma = 5.0 * std::sqrt(0.5 / probes);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(estimate.log_mu[i] / std::sqrt(exact[i]), 1.0, five_sigma);
  }
}

}  // namespace
}  // namespace kappamu::inverse
