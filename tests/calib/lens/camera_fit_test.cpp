// The camera's least-squares problem itself: its derivatives against differences of its residuals.
#include "calib/lens/camera_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calib/lens/lens_model.h"
#include "calib/lens/pose_numbers.h"
#include "tests/calib/board_scene.h"

namespace kappamu::calib {
namespace {

/// d(residual of one corner) / d(parameter block), by Ceres' evaluation and by central differences.
class Derivatives {
 public:
  Derivatives(const CameraSetting& setting, const CameraFit& fit) : setting_(setting), fit_(fit) {}

  Eigen::VectorXd differences(double* parameter, double step) {
    const double value = *parameter;
    *parameter = value + step;
    const Eigen::VectorXd up = residuals();
    *parameter = value - step;
    const Eigen::VectorXd down = residuals();
    *parameter = value;
    return (up - down) / (2.0 * step);
  }

  /// Row per residual of view 0, columns lens, bend, pose.
  Eigen::MatrixXd exact() {
    CameraProblem problem(setting_, fit_, fit_.model, Bend::free);
    return problem.jacobian(0);
  }

  CameraFit& fit() { return fit_; }

 private:
  Eigen::VectorXd residuals() const {
    const BoardCorners& corners = setting_.views[0].corners;
    Eigen::VectorXd result(2 * corners.columns * corners.rows);
    for (int j = 0; j < corners.rows; ++j) {
      for (int i = 0; i < corners.columns; ++i) {
        result.segment<2>(2 * (j * corners.columns + i)) =
            corner_residual(setting_, fit_, 0, static_cast<std::size_t>(j * corners.columns + i));
      }
    }
    return result;
  }

  const CameraSetting& setting_;
  CameraFit fit_;
};

TEST(CameraFit, DerivativesAreThoseOfTheResiduals) {
  const Lens lens{
      640, 480, 820.0, 830.0, 322.0, 236.0, {-0.2, 0.3, 0.004, -0.003, 0.1, 0.05, -0.04, 0.02}};
  std::mt19937 random(3);
  const Rigid pose = testing::tilted(0.4, -0.3, 0.2, {6.0, 4.0, 70.0}, {16.0, 10.0, 0.0});
  const std::vector<BoardView> views{testing::seen(lens, pose, 9, 6, 4.0, 0.5, random)};
  const CameraSetting setting{views, 4.0, {std::vector<std::uint8_t>(54, 1)}};
  CameraFit fit;
  fit.model = LensModel::rational;
  fit.numbers = numbers_of(lens);
  fit.bend_mm = {0.3, -0.2};
  fit.poses = {six_of(pose)};
  Derivatives derivatives(setting, fit);
  const Eigen::MatrixXd exact = derivatives.exact();
  ASSERT_EQ(exact.cols(), lens_numbers + 2 + 6);
  for (int k = 0; k < exact.cols(); ++k) {
    double* parameter = k < lens_numbers       ? &derivatives.fit().numbers[k]
                        : k < lens_numbers + 2 ? &derivatives.fit().bend_mm[k - lens_numbers]
                                               : &derivatives.fit().poses[0][k - lens_numbers - 2];
    const double step = 1e-5 * std::max(1.0, std::abs(*parameter));
    const Eigen::VectorXd by_differences = derivatives.differences(parameter, step);
    // Second-order differences: 1e-10 of curvature, and rounding of 1e-13 over 1e-5.
    EXPECT_LT((exact.col(k) - by_differences).norm(), 1e-6 * (1.0 + by_differences.norm()))
        << "parameter " << k;
  }
}

}  // namespace
}  // namespace kappamu::calib
