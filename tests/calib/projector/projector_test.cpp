#include "calib/projector/projector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/lens/lens_model.h"
#include "tests/calib/projector/projector_scene.h"
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

TEST(Projector, DistortionIsMeasuredWhetherThereIsSomeOrNot) {
  constexpr double noise_px = 0.05;
  constexpr int runs = 12;
  for (const double k1 : {0.0, -0.4}) {
    Rig rig;
    rig.projector.distortion[0] = k1;
    double reduced = 0.0;
    for (int run = 0; run < runs; ++run) {
      const ProjectorCalibration found = calibrate_projector(
          rig.camera, rig.printed, rig.projected, rig.planes(8, noise_px, 40 + run), 1024, 768);
      reduced += std::pow(found.lens.distortion[0] - k1, 2) / found.covariance(4, 4) / runs;
      EXPECT_LT(found.rms_px, 0.3);  // the bar set for the demo
      // Two coordinates of noise, 864 residuals: 2.5 % standard error, 8 % lost to the parameters.
      EXPECT_NEAR(found.printed_rms_px, std::sqrt(2.0) * noise_px,
                  0.15 * std::sqrt(2.0) * noise_px);
    }
    // Mean of 12 squared standard normals: standard error 0.41; less where the prior tells more
    // than the planes.
    EXPECT_LT(reduced, 1.0 + 3.5 * 0.41) << k1;
  }
}

// Three planes do not tell distortion: what is left open is stated, and no more than lenses have.
TEST(Projector, WhatThreePlanesLeaveOpenIsStated) {
  const Rig rig;
  const ProjectorCalibration found = calibrate_projector(rig.camera, rig.printed, rig.projected,
                                                         rig.planes(3, 0.05, 7), 1024, 768);
  EXPECT_LT(std::abs(found.lens.cx - rig.projector.cx), 4.0 * std::sqrt(found.covariance(2, 2)));
  EXPECT_LT(std::abs(found.lens.cy - rig.projector.cy), 4.0 * std::sqrt(found.covariance(3, 3)));
  EXPECT_LT(std::sqrt(found.covariance(6, 6)), 1.01 * tangential_spread);
}

// Errors in units of the stated standard deviation, over repeated noise.
TEST(Projector, CovarianceIsTheSpreadOfRepeatedCalibrations) {
  const Rig rig;
  constexpr int runs = 25;
  double focal = 0.0;
  double height = 0.0;
  for (int run = 0; run < runs; ++run) {
    const ProjectorCalibration found = calibrate_projector(
        rig.camera, rig.printed, rig.projected, rig.planes(6, 0.05, 10 + run), 1024, 768);
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
