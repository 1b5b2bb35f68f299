// Errors that neighbouring pixels share, measured from maps, pictures and patterns of known ones.
#include "calib/light/shared_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/numbers/cosine_transform.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;

constexpr FaceShape face{48, 40};

/// Errors of `octave` in each octave of frequency, as fits take them, beside white noise of
/// `noise`.
FaceMap drawn(double octave, double noise, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd waves(face.nu, face.nv);
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      const double f2 = std::pow(0.5 * u / face.nu, 2) + std::pow(0.5 * v / face.nv, 2);
      const double size =
          f2 > 0.0 ? octave / std::sqrt(2.0 * std::numbers::pi * std::numbers::ln2 * f2) : 0.0;
      waves(u, v) = size * normal(engine);
    }
  }
  const Eigen::MatrixXd image =
      from_waves(CosineTransform(face.nu), CosineTransform(face.nv), waves);
  FaceMap map{face, std::vector<double>(image.data(), image.data() + image.size()),
              std::vector<double>(face.cells(), noise * noise)};
  for (double& x : map.relative) x += noise * normal(engine);
  return map;
}

double mean_error(double octave, double noise) {
  double square = 0.0;
  constexpr unsigned draws = 20;
  for (unsigned k = 1; k <= draws; ++k) {
    square += std::pow(octave_error(drawn(octave, noise, k)), 2) / draws;
  }
  return std::sqrt(square);
}

TEST(SharedError, OfAnOctaveIsWhatWasDrawn) {
  EXPECT_NEAR(mean_error(2e-3, 1e-4) / 2e-3, 1.0, 0.15);
  EXPECT_NEAR(mean_error(2e-3, 2e-3) / 2e-3, 1.0, 0.15) << "noise is taken off";
  EXPECT_LT(mean_error(0.0, 2e-3), 3e-4);
}

/// `patterns` even ones; the odd ones' values are those of the even ones with an error of `own`.
SurfaceMeasurements even_patterns(double own, int patterns) {
  SurfaceMeasurements m;
  m.grid = {face.nu, face.nv, 6, 0.5};
  m.channels = {"grey"};
  m.patterns = patterns;
  for (int p = 0; p < patterns; ++p) {
    const FaceMap map = drawn(own, 1e-3, static_cast<unsigned>(p) + 1);
    for (std::size_t i = 0; i < face.cells(); ++i) {
      m.irradiance.push_back(p < 2 ? 1.0F : 0.1F * static_cast<float>(p));
      m.value.push_back(static_cast<float>(0.2 * (1.0 + map.relative[i])));
      m.variance.push_back(4e-8F);
    }
  }
  return m;
}

TEST(SharedError, OfEachPatternIsThatOfPatternsPhotographedTwice) {
  const SharedError found = shared_error({}, {}, even_patterns(4e-3, 4));
  EXPECT_NEAR(found.error.own / 4e-3, 1.0, 0.4) << "one pair";
  EXPECT_NEAR(found.error.common / found.error.own, 0.4, 0.03);
  EXPECT_THAT(found.source, HasSubstr("own from patterns photographed twice"));
}

TEST(SharedError, IsTheUsualInstrumentsWhereNothingTells) {
  const SharedError found = shared_error({}, {}, even_patterns(4e-3, 1));
  EXPECT_NEAR(found.error.common, 2e-3, 1e-5);
  EXPECT_NEAR(found.error.own, 5e-3, 1e-5);
  EXPECT_THAT(found.source, HasSubstr("not measured"));
}

TEST(SharedError, IsWhatTheTargetTellsBesideWhatItCannot) {
  WhiteReference white;
  white.smooth_error = 3e-4;
  SurfaceMeasurements m = even_patterns(0.0, 1);
  const SharedError back = shared_error({}, white, m);
  EXPECT_NEAR(back.error.common, std::hypot(3e-4, 1e-4), 1e-9);
  EXPECT_NEAR(back.error.own, std::hypot(7.5e-4, 1e-4), 1e-9);
  EXPECT_THAT(back.source, HasSubstr("own in proportion to common"));
  white.level_error = 2e-4;
  m.seen_face = m.lit_face;
  const SharedError front = shared_error({}, white, m);
  EXPECT_NEAR(front.error.own, std::hypot(2e-4, 8e-4), 1e-9);
  EXPECT_THAT(front.source, HasSubstr("under several values"));
}

TEST(SharedError, IsWhatTheSessionStates) {
  capture::Session session;
  session.smooth_error = SmoothError{1e-3, 3e-3};
  WhiteReference white;
  white.smooth_error = 3e-4;
  const SharedError found = shared_error(session, white, even_patterns(0.0, 1));
  EXPECT_EQ(found.error, *session.smooth_error);
  EXPECT_EQ(found.source, "stated by the session");
}

}  // namespace
}  // namespace kappamu::calib
