// Stated uncertainties against the spread over new noise, on the simulated rig's own views. Corners
// are drawn by geometry.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "calib/lens/camera.h"
#include "calib/lens/projection_uncertainty.h"
#include "data_synthetic/rig/rig.h"
#include "tests/calib/board_scene.h"

namespace kappamu::calib {
namespace {

/// Per coordinate: between rendered sessions' 0.0014 px and what real boards leave, 0.10 px
/// (docs/calibration.md); all errors go with it.
constexpr double corner_noise_px = 0.03;

/// The views a session has of the printed board: moved before the camera, and on the planes.
std::vector<Rigid> view_poses(const synthetic::Rig& rig) {
  std::vector<Rigid> poses = rig.camera_from_board;
  const Rigid camera_from_world = rig.world_from_camera.at(synthetic::front_station).inverse();
  for (const Rigid& plane : rig.world_from_plane) {
    poses.push_back(camera_from_world * plane * rig.plane_from_board);
  }
  return poses;
}

std::vector<BoardView> views_of(const synthetic::Rig& rig, std::mt19937& random) {
  std::vector<BoardView> views;
  for (const Rigid& pose : view_poses(rig)) {
    views.push_back(testing::seen(rig.camera_lens, pose, rig.board.columns, rig.board.rows,
                                  rig.board.square_mm, corner_noise_px, random));
  }
  return views;
}

CameraCalibration calibrated(const synthetic::Rig& rig, std::mt19937& random,
                             std::optional<LensModel> model = std::nullopt) {
  return calibrate_camera(views_of(rig, random), rig.board.square_mm, rig.camera_lens.width,
                          rig.camera_lens.height, model);
}

/// The largest count that a binomial variable stays below with probability under `tail`.
int lower_bound(int runs, double probability, double tail) {
  double sum = 0.0;
  double term = std::pow(1.0 - probability, runs);
  for (int k = 0; k <= runs; ++k) {
    sum += term;
    if (sum > tail) return k;
    term *= (runs - k) / (k + 1.0) * probability / (1.0 - probability);
  }
  return runs;
}

// Model chosen anew in every run, so that a coefficient missed or taken in vain shows.
TEST(CameraUncertainty, IntrinsicsLieWithinTwoDeviationsInNinetyFiveOfAHundredRuns) {
  constexpr int runs = 50;
  std::array<int, 4> within{};
  int within_ellipsoid = 0;
  std::array<double, 4> squares{};
  for (int run = 0; run < runs; ++run) {
    synthetic::SimulationOptions options;
    options.seed = 1 + run;  // other board poses, too
    const synthetic::Rig rig = synthetic::make_rig(options);
    std::mt19937 random(100 + run);
    const CameraCalibration found = calibrated(rig, random);
    const Lens& truth = rig.camera_lens;
    const Eigen::Vector4d error(found.lens.fx - truth.fx, found.lens.fy - truth.fy,
                                found.lens.cx - truth.cx, found.lens.cy - truth.cy);
    for (int k = 0; k < 4; ++k) {
      const double reduced = error[k] / found.standard_deviation(k);
      squares[k] += reduced * reduced / runs;
      within[k] += std::abs(reduced) <= 2.0 ? 1 : 0;
    }
    constexpr double chi2_4_at_95_percent = 9.488;
    const Eigen::Matrix4d covariance = found.covariance.topLeftCorner<4, 4>();
    if (error.dot(covariance.inverse() * error) <= chi2_4_at_95_percent) ++within_ellipsoid;
  }
  // Fewer than this happen once in a thousand if the deviations are right.
  const int least = lower_bound(runs, 0.9545, 1e-3);
  const int least_ellipsoid = lower_bound(runs, 0.95, 1e-3);
  std::printf("within two deviations, of %d: fx %d fy %d cx %d cy %d (at least %d), all four %d\n",
              runs, within[0], within[1], within[2], within[3], least, within_ellipsoid);
  std::printf("mean squared error over variance: %.2f %.2f %.2f %.2f\n", squares[0], squares[1],
              squares[2], squares[3]);
  for (int k = 0; k < 4; ++k) {
    EXPECT_GE(within[k], least) << "parameter " << k;
    // Nor are they far too large: the mean of 50 has a standard error of 0.2.
    EXPECT_GT(squares[k], 0.3) << "parameter " << k;
  }
  EXPECT_GE(within_ellipsoid, least_ellipsoid);
}

TEST(CameraUncertainty, ProjectionSpreadsAsPredictedAcrossTheFrame) {
  constexpr int runs = 100;
  constexpr int across = 5;
  constexpr int every = 5;  // run states its deviations
  const synthetic::Rig rig = synthetic::make_rig({});
  const Lens& truth = rig.camera_lens;
  const std::vector<Rigid> poses = view_poses(rig);
  const double distance_mm = 4.2 * rig.size_mm;  // the sample's from the back station
  std::mt19937 random(7);
  std::vector<double> predicted(across * across, 0.0);
  std::vector<double> sampled(across * across, 0.0);
  for (int run = 0; run < runs; ++run) {
    const CameraCalibration found = calibrated(rig, random, LensModel::radial2_tangential);
    for (int k = 0; k < across * across; ++k) {
      const Eigen::Vector2d pixel((truth.width - 1.0) * (k % across) / (across - 1.0),
                                  (truth.height - 1.0) * (k / across) / (across - 1.0));
      // The deviation is estimated from the views' scatter and varies from run to run.
      if (run % every == 0) {
        predicted[k] += projection_covariance(found, pixel, distance_mm).trace() * every / runs;
      }
      const Eigen::Vector3d point = distance_mm * truth.unproject(pixel);
      sampled[k] += (projected_through_boards(found, poses, point) - pixel).squaredNorm() / runs;
    }
  }
  double worst = 0.0;
  for (int k = 0; k < across * across; ++k) {
    const double ratio = std::sqrt(predicted[k] / sampled[k]);
    worst = std::max(worst, std::abs(ratio - 1.0));
    // 100 runs know a deviation to 6 %.
    EXPECT_NEAR(ratio, 1.0, 0.15) << "field " << k % across << ", " << k / across;
  }
  std::printf(
      "predicted / sampled deviation off by %.3f at most; %.4f px at the middle, %.4f px in "
      "the corner\n",
      worst, std::sqrt(predicted[across * across / 2]), std::sqrt(predicted[0]));
}

}  // namespace
}  // namespace kappamu::calib
