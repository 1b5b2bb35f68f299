// The shift and scale that a volume shows, against dense matrices and of structured blocks. How
// often they are reported, over many blocks: `kappamu-studies limits --section consistency`.
#include "inverse/data_checks/volume_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "inverse/fit/fit.h"
#include "tests/cases/limit_inverse_case.h"
#include "tests/cases/media.h"
#include "tests/inverse/inverse_cases.h"
#include "tests/inverse/joined.h"

namespace kappamu::inverse {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(VolumeErrors, IsTheJointMinimumToFirstOrder) {
  constexpr GridShape shape{5, 4, 3, 0.5};
  constexpr int patterns = 4;
  const Prior prior{20.0, 15.0};
  cases::Noise noise(7);
  Problem problem = cases::randomly_lit(shape, patterns, noise);
  const CoefficientPair at = cases::rough_medium(shape, 0.2, 3);
  const std::vector<double> prediction = cases::simulate(problem.setup, at, problem.seen_face,
                                                         problem.irradiance, patterns, "reference");
  for (const double m : prediction) {
    problem.data.push_back(m * (1.0 + 0.01 * noise.normal()));
    problem.weight.push_back(std::pow(0.01 * m, -2));
  }
  problem.weight[3] = 0.0;
  const Backend backend{"reference", forward::Precision::double_precision, {1e-12, 2000}, 16, 64.0};
  Objective objective(problem, backend);
  objective.value(at);

  // The residual's derivatives by the 120 unknowns and, by differences, by shifts, and by the
  // scale.
  const auto n = static_cast<Index>(2 * shape.cells());
  const auto rows = static_cast<Index>(prediction.size());
  MatrixXd j(rows, n + 3);
  MatrixXd h = MatrixXd::Zero(n + 3, n + 3);
  for (Index k = 0; k < n; ++k) {
    const CoefficientPair unit = parted(VectorXd::Unit(n, k));
    const std::vector<double> column = objective.jacobian(unit);
    j.col(k) = Eigen::Map<const VectorXd>(column.data(), rows);
    h.col(k).head(n) = prior.weight * joined(smoothing_product(objective.space(),
                                                               prior.anchor_length_mm, {}, unit));
  }
  VectorXd residual(rows);
  const FaceShape face = problem.seen_shape();
  for (Index i = 0; i < rows; ++i) {
    const auto at_pixel = static_cast<std::size_t>(i);
    const double root = std::sqrt(problem.weight[at_pixel]);
    const std::size_t first = at_pixel / face.cells() * face.cells();
    const int u = static_cast<int>((at_pixel - first) % static_cast<std::size_t>(face.nu));
    const int v = static_cast<int>((at_pixel - first) / static_cast<std::size_t>(face.nu));
    const auto map = [&](int uu, int vv) {
      return prediction[first + static_cast<std::size_t>(std::clamp(vv, 0, face.nv - 1) * face.nu +
                                                         std::clamp(uu, 0, face.nu - 1))];
    };
    const double wide = u > 0 && u + 1 < face.nu ? 2.0 : 1.0;
    const double high = v > 0 && v + 1 < face.nv ? 2.0 : 1.0;
    j(i, n) = root * (map(u - 1, v) - map(u + 1, v)) / wide;
    j(i, n + 1) = root * (map(u, v - 1) - map(u, v + 1)) / high;
    j(i, n + 2) = root * map(u, v);
    residual[i] = root * (problem.data[at_pixel] - prediction[at_pixel]);
  }
  h += j.transpose() * j;
  VectorXd pull = j.transpose() * residual;
  VectorXd from_mean = joined(at);
  for (const Index first : {Index{0}, n / 2}) {
    from_mean.segment(first, n / 2).array() -= from_mean.segment(first, n / 2).mean();
  }
  pull.head(n) -= prior.weight * joined(smoothing_product(objective.space(), prior.anchor_length_mm,
                                                          {}, parted(from_mean)));
  const MatrixXd covariance = h.llt().solve(MatrixXd::Identity(n + 3, n + 3));
  const VectorXd expected = covariance * pull;

  const VolumeErrors found = volume_errors(objective, at, prior, {.most = 200}, 1);
  const auto expect = [&](const Estimate& estimate, Index k) {
    const double deviation = std::sqrt(covariance(n + k, n + k));
    EXPECT_NEAR(estimate.error / deviation, 1.0, 0.1) << k;
    // Conjugate gradients stop by what S still changes; the fields' gradient, large here, sees
    // more.
    EXPECT_NEAR((estimate.value - expected[n + k]) / deviation, 0.0, 0.4) << k;
  };
  expect(found.shift_u, 0);
  expect(found.shift_v, 1);
  ASSERT_TRUE(found.log_scale);
  expect(*found.log_scale, 2);
}

Consistency fitted(std::uint64_t seed, const test_cases::Mistake& mistake) {
  const test_cases::Block block{.grid = {12, 12, 6, 0.5}};
  SurfaceMeasurements m =
      test_cases::expose_figure(block, test_cases::structured_block(0.2, 0.02, 1.0, seed),
                                test_cases::bar_light(block.grid, block.lit, 8), 2, 1.3);
  test_cases::spoil(m, block.noise, mistake, seed);
  Progress silent;
  return fit_channel(m, 0, {}, {}, silent).report.consistency;
}

TEST(VolumeErrors, AThirdOfAVoxelIsReportedOfStructuredBlocks) {
  for (const std::uint64_t seed : {11, 12}) {
    const Consistency right = fitted(seed, {});
    EXPECT_TRUE(right.volume_shift);
    EXPECT_FALSE(right.is_shifted()) << right.shift_u.value << " " << right.shift_v.value;
    const Consistency shifted = fitted(seed, {.shift = 0.33});
    EXPECT_TRUE(shifted.is_shifted());
    EXPECT_NEAR(shifted.shift_u.value, 0.33, 0.15);
    EXPECT_NEAR(shifted.shift_v.value, 0.0, 0.1);
  }
}

TEST(VolumeErrors, AFifthTooMuchLightIsReportedOfStructuredBlocks) {
  for (const std::uint64_t seed : {13, 14}) {
    const Consistency right = fitted(seed, {});
    EXPECT_FALSE(right.scale_is_wrong()) << right.by_volume->scale_gain;
    const Consistency bright = fitted(seed, {.scale = 1.2});
    EXPECT_FALSE(bright.block_scale_is_wrong());
    EXPECT_TRUE(bright.is_too_bright()) << bright.by_volume->scale_gain;
    EXPECT_THAT(brightness_sentence(bright), ::testing::HasSubstr("All values seem too high"));
  }
}

}  // namespace
}  // namespace kappamu::inverse
