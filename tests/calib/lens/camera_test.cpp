#include "calib/lens/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/calib/board_scene.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using testing::board_poses;
using ::testing::HasSubstr;
using testing::seen;

constexpr int columns = 9;
constexpr int rows = 6;
constexpr double square_mm = 4.0;

Lens camera_lens() {
  return {640, 480, 820.0, 823.0, 322.0, 236.0, {-0.12, 0.08, 0.0015, -0.001, 0.0}};
}

std::vector<BoardView> views_of(const Lens& lens, double noise_px, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<BoardView> views;
  for (const Rigid& pose : board_poses(columns, rows, square_mm, 75.0, random)) {
    views.push_back(seen(lens, pose, columns, rows, square_mm, noise_px, random));
  }
  return views;
}

TEST(Camera, ExactCornersGiveTheExactLens) {
  const Lens truth = camera_lens();
  const CameraCalibration found = calibrate_camera(views_of(truth, 0.0, 3), square_mm, truth.width,
                                                   truth.height, LensModel::full);
  // The solver's own stopping tolerances; corners pass through single precision only at the start.
  EXPECT_TRUE(found.converged);
  EXPECT_LT(found.rms_px, 1e-6);
  EXPECT_NEAR(found.lens.fx, truth.fx, 1e-4);
  EXPECT_NEAR(found.lens.fy, truth.fy, 1e-4);
  EXPECT_NEAR(found.lens.cx, truth.cx, 1e-4);
  EXPECT_NEAR(found.lens.cy, truth.cy, 1e-4);
}

TEST(Camera, RmsIsTheNoiseThatWasAdded) {
  constexpr double noise_px = 0.1;
  const CameraCalibration found =
      calibrate_camera(views_of(camera_lens(), noise_px, 5), square_mm, 640, 480);
  // Two coordinates of noise_px each, 1296 of them: 2 % standard error, less 6 % for the
  // parameters.
  EXPECT_NEAR(found.rms_px, std::sqrt(2.0) * noise_px, 0.12 * std::sqrt(2.0) * noise_px);
  EXPECT_EQ(found.views.size(), 12U);
}

// The stated covariance against the spread of repeated calibrations from new noise.
TEST(Camera, CovarianceIsTheSpreadOfRepeatedCalibrations) {
  constexpr int runs = 40;
  constexpr double noise_px = 0.1;
  const Lens truth = camera_lens();
  std::mt19937 random(6);
  const std::vector<Rigid> poses = board_poses(columns, rows, square_mm, 75.0, random);
  Eigen::Matrix<double, 4, 1> squares = Eigen::Matrix<double, 4, 1>::Zero();
  for (int run = 0; run < runs; ++run) {
    std::vector<BoardView> views;
    for (const Rigid& pose : poses) {
      views.push_back(seen(truth, pose, columns, rows, square_mm, noise_px, random));
    }
    const CameraCalibration found =
        calibrate_camera(views, square_mm, 640, 480, LensModel::radial2_tangential);
    const double deviations[4] = {found.lens.fx - truth.fx, found.lens.fy - truth.fy,
                                  found.lens.cx - truth.cx, found.lens.cy - truth.cy};
    for (int k = 0; k < 4; ++k) {
      squares[k] += std::pow(deviations[k] / found.standard_deviation(k), 2);
    }
  }
  // Mean of 40 squared standard normals: standard error sqrt(2/40) = 0.22; four of them.
  const Eigen::Matrix<double, 4, 1> reduced = squares / runs;
  for (int k = 0; k < 4; ++k) {
    EXPECT_GT(reduced[k], 1.0 - 3.5 * 0.22) << "parameter " << k;
    EXPECT_LT(reduced[k], 1.0 + 3.5 * 0.22) << "parameter " << k;
  }
}

TEST(Camera, TwoViewsAreRefusedInOneSentence) {
  std::vector<BoardView> views = views_of(camera_lens(), 0.0, 7);
  views.resize(2);
  const std::string sentence = sentence_of([&] { calibrate_camera(views, square_mm, 640, 480); });
  EXPECT_THAT(sentence, HasSubstr("2 board photographs given and at least 3 are needed"));
  EXPECT_THAT(sentence, HasSubstr("calibration.camera_boards"));
}

TEST(Camera, ViewsWithoutTiltDoNotDetermineTheLens) {
  std::mt19937 random(8);
  std::vector<BoardView> views;
  for (int view = 0; view < 5; ++view) {
    const Rigid pose = testing::tilted(0.0, 0.0, 0.1 * view, {2.0 * view, 0.0, 80.0 + 5.0 * view},
                                       {16.0, 10.0, 0.0});
    views.push_back(seen(camera_lens(), pose, columns, rows, square_mm, 0.05, random));
  }
  EXPECT_THROW(
      {
        const CameraCalibration found = calibrate_camera(views, square_mm, 640, 480);
        // A calibration that admits it knows nothing is as good as a refusal.
        if (found.standard_deviation(0) > 0.05 * found.lens.fx) throw InputError("undetermined");
      },
      InputError);
}

TEST(Camera, BoardPoseIsRecovered) {
  std::mt19937 random(9);
  const Lens lens = camera_lens();
  const Rigid pose = testing::tilted(0.4, -0.2, 0.1, {3.0, -2.0, 80.0}, {16.0, 10.0, 0.0});
  const BoardView view = seen(lens, pose, columns, rows, square_mm, 0.0, random);
  const Rigid found = board_pose(lens, view.corners, square_mm, "synthetic");
  // Corners pass through single precision in OpenCV.
  EXPECT_LT((found.translation - pose.translation).norm(), 1e-2);
  EXPECT_LT((found.rotation - pose.rotation).norm(), 1e-3);
}

}  // namespace
}  // namespace kappamu::calib
