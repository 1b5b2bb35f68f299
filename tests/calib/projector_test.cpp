#include "calib/projector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "projector_scene.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;

using Rig = testing::ProjectorScene;

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
