// What a change of the data does to a fit, to first order and by fitting again.
#include "studies/inverse/dense_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "tests/cases/inverse_case.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

class DenseFits : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    Block block;
    block.grid = {8, 8, 4, 0.5};
    TruthSpec truth;
    truth.contrast = 2.0;
    measurements_ = expose_patches(block, make_truth(block.grid.refined(2), truth), 3);
    add_noise(measurements_, 0.01, 1);
    inverse::FitOptions options;
    options.solver.backend.device = "reference";
    options.solver.backend.precision = forward::Precision::double_precision;
    options.solver.backend.solve = {1e-9, 500};
    options.data.model_error = {0.0, 0.0};
    fit_ = std::make_unique<DenseFit>(measurements_, 0, options);
  }
  static void TearDownTestSuite() { fit_.reset(); }

  /// How far the linear change is from the one found by fitting again, relative.
  static double miss(const SurfaceMeasurements& other) {
    const Eigen::VectorXd found = fit_->refitted(other);
    EXPECT_GT(found.cwiseAbs().maxCoeff(), 1e-3);
    return (fit_->change(other) - found).norm() / found.norm();
  }

  static SurfaceMeasurements measurements_;
  static std::unique_ptr<DenseFit> fit_;
};
SurfaceMeasurements DenseFits::measurements_;
std::unique_ptr<DenseFit> DenseFits::fit_;

TEST_F(DenseFits, SameDataChangeNothing) {
  EXPECT_LT(fit_->change(measurements_).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(fit_->refitted(measurements_).cwiseAbs().maxCoeff(), 1e-4);
}

// A brighter camera, and a projector that lights a hundredth of a voxel further along x.
TEST_F(DenseFits, ScaleAndShiftOfLightActToFirstOrder) {
  SurfaceMeasurements brighter = measurements_;
  for (float& value : brighter.value) value *= 1.002F;
  EXPECT_LT(miss(brighter), 0.1);

  SurfaceMeasurements shifted = measurements_;
  const auto width = static_cast<std::size_t>(shifted.lit_shape().nu);
  for (std::size_t i = 0; i < shifted.irradiance.size(); ++i) {
    const float left = i % width == 0 ? 0.0F : measurements_.irradiance[i - 1];
    shifted.irradiance[i] = 0.99F * measurements_.irradiance[i] + 0.01F * left;
  }
  EXPECT_LT(miss(shifted), 0.2);
}

TEST_F(DenseFits, NoiseSpreadsAsPropagated) {
  std::mt19937_64 random(2);
  std::normal_distribution<float> unit;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(fit_->unknowns());
  constexpr int draws = 100;
  for (int k = 0; k < draws; ++k) {
    SurfaceMeasurements noisy = measurements_;
    for (std::size_t i = 0; i < noisy.value.size(); ++i) {
      noisy.value[i] += std::sqrt(noisy.variance[i]) * unit(random);
    }
    squares += fit_->change(noisy).cwiseAbs2() / draws;
  }
  // 100 draws know the variance of one unknown to 14 %, the sum over hundreds of them better.
  const Variances propagated = fit_->propagated(measurements_);
  EXPECT_NEAR(squares.sum() / propagated.sum(), 1.0, 0.15);
  EXPECT_NEAR(squares.head(256).sum() / propagated.head(256).sum(), 1.0, 0.15);
}

}  // namespace
}  // namespace kappamu::studies
