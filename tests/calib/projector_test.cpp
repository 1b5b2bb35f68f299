#include "calib/projector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "board_scene.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;

constexpr double square_mm = 4.0;

/// A camera, a projector beside it, and planes that carry a printed and a projected board.
struct Rig {
  Lens camera{1280, 960, 1700.0, 1702.0, 641.0, 476.0, {-0.1, 0.05, 0.0, 0.0, 0.0}};
  Lens projector{1024, 768, 1500.0, 1500.0, 500.0, 700.0, {}};
  Rigid projector_from_station;
  capture::Board printed{9, 6, square_mm};
  capture::ProjectedBoard projected{9, 6, 40.0, {500.0, 200.0}};

  Rig() {
    projector_from_station.rotation =
        Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()).toRotationMatrix();
    projector_from_station.translation = {35.0, 25.0, 8.0};
  }

  std::vector<PlaneView> planes(int count, double noise_px, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::normal_distribution<double> noise(0.0, noise_px);
    std::vector<PlaneView> views;
    for (int p = 0; p < count; ++p) {
      const Rigid pose = testing::tilted(0.5 * unit(random), 0.5 * unit(random), 0.1 * unit(random),
                                         {-18.0, 4.0 * unit(random), 160.0 + 15.0 * unit(random)},
                                         {0.5 * square_mm * 8, 0.5 * square_mm * 5, 0.0});
      PlaneView view;
      view.name = "plane";
      view.printed = testing::seen(camera, pose, 9, 6, square_mm, noise_px, random).corners;
      view.projected = {9, 6, {}};
      const Rigid projector_from_plane = projector_from_station * pose;
      for (int j = 0; j < 6; ++j) {
        for (int i = 0; i < 9; ++i) {
          const Eigen::Vector2d pixel(500.0 + 40.0 * i, 200.0 + 40.0 * j);
          const Eigen::Vector3d point = meet_plane(projector, projector_from_plane, pixel);
          Eigen::Vector2d seen_at = camera.project(pose * point);
          seen_at += Eigen::Vector2d(noise(random), noise(random));
          view.projected.pixels.push_back(seen_at);
        }
      }
      views.push_back(view);
    }
    return views;
  }
};

TEST(Projector, ExactCornersGiveTheExactProjector) {
  const Rig rig;
  const ProjectorCalibration found =
      calibrate_projector(rig.camera, rig.printed, rig.projected, rig.planes(6, 0.0, 1), 1024, 768);
  EXPECT_TRUE(found.converged);
  EXPECT_LT(found.rms_px, 1e-5);  // stopping tolerance of the solver
  EXPECT_NEAR(found.lens.fx, rig.projector.fx, 1e-2);
  EXPECT_NEAR(found.lens.cy, rig.projector.cy, 1e-2);
  const Rigid& pose = found.projector_from_station;
  EXPECT_LT((pose.translation - rig.projector_from_station.translation).norm(), 1e-3);
  EXPECT_LT((pose.rotation - rig.projector_from_station.rotation).norm(), 1e-5);
}

TEST(Projector, DistortionIsSeldomInventedAndTheErrorIsTheCameras) {
  const Rig rig;
  constexpr double noise_px = 0.05;
  constexpr int runs = 12;
  int inventions = 0;
  for (int run = 0; run < runs; ++run) {
    const ProjectorCalibration found = calibrate_projector(
        rig.camera, rig.printed, rig.projected, rig.planes(8, noise_px, 40 + run), 1024, 768);
    inventions += found.model != LensModel::pinhole_square ? 1 : 0;
    EXPECT_LT(found.rms_px, 0.3);  // the bar set for the demo
    // Two coordinates of noise, 864 residuals: 2.5 % standard error, 8 % lost to the parameters.
    EXPECT_NEAR(found.printed_rms_px, std::sqrt(2.0) * noise_px, 0.15 * std::sqrt(2.0) * noise_px);
  }
  // The criterion errs with probability P(chi2_1 > ln 1728) = 0.6 % per parameter tried; 3 of 12
  // would be an accident of less than one in a thousand.
  EXPECT_LT(inventions, 3);
}

TEST(Projector, DistortionIsFoundWhereThereIsSome) {
  Rig rig;
  rig.projector.distortion[0] = -0.4;
  const ProjectorCalibration found = calibrate_projector(rig.camera, rig.printed, rig.projected,
                                                         rig.planes(10, 0.02, 3), 1024, 768);
  EXPECT_NE(found.model, LensModel::pinhole_square);
  EXPECT_NEAR(found.lens.distortion[0], -0.4, 4.0 * std::sqrt(found.covariance(4, 4)));
}

// Errors in units of the stated standard deviation, over repeated noise.
TEST(Projector, CovarianceIsTheSpreadOfRepeatedCalibrations) {
  const Rig rig;
  constexpr int runs = 25;
  double focal = 0.0;
  double height = 0.0;
  for (int run = 0; run < runs; ++run) {
    const ProjectorCalibration found =
        calibrate_projector(rig.camera, rig.printed, rig.projected, rig.planes(6, 0.05, 10 + run),
                            1024, 768, LensModel::pinhole_square);
    focal += std::pow(found.lens.fx - rig.projector.fx, 2) / found.covariance(0, 0);
    height += std::pow(found.projector_from_station.translation.y() -
                           rig.projector_from_station.translation.y(),
                       2) /
              found.pose_covariance(4, 4);
  }
  // Mean of 25 squared standard normals: standard error sqrt(2/25) = 0.28.
  constexpr double standard_error = 0.28;
  EXPECT_NEAR(focal / runs, 1.0, 3.5 * standard_error);
  EXPECT_NEAR(height / runs, 1.0, 3.5 * standard_error);
}

TEST(Projector, TwoPlanesAreRefusedInOneSentence) {
  const Rig rig;
  const std::string sentence = sentence_of([&] {
    calibrate_projector(rig.camera, rig.printed, rig.projected, rig.planes(2, 0.0, 4), 1024, 768);
  });
  EXPECT_THAT(sentence, HasSubstr("2 planes given and at least 3 are needed"));
  EXPECT_THAT(sentence, HasSubstr("calibration.projector_planes"));
}

}  // namespace
}  // namespace kappamu::calib
