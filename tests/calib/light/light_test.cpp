// Scale, flat field, chart, footprints and irradiance on pictures made from their definitions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/light/irradiance.h"
#include "calib/light/radiometry.h"
#include "calib/sample/face.h"
#include "calib/sample/footprint.h"
#include "calib/targets/chart.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;

const GridShape block{20, 16, 6, 1.0};

Lens plain_lens() {
  return {320, 240, 900.0, 900.0, 160.0, 118.0, {-0.2, 0.3, 0.0, 0.0, 0.0}};
}

/// Looks at z- from 100 mm before its middle, slightly turned.
Rigid before_lit_face() {
  Rigid pose;
  pose.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix();
  pose.translation = Eigen::Vector3d(0.3, -0.2, 100.0) - pose.rotation * Eigen::Vector3d(10, 8, 0);
  return pose;
}

/// Signal `value(x, y)` on the plane of z-, x, y in mm.
template <class Value>
capture::HdrImage picture(const Value& value) {
  const Lens lens = plain_lens();
  const Rigid sample_from_camera = before_lit_face().inverse();
  capture::HdrImage image{Image<float>(lens.width, lens.height, 1),
                          Image<float>(lens.width, lens.height, 1, 1e-6F),
                          Image<std::uint8_t>(lens.width, lens.height, 1)};
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      const Eigen::Vector3d ray = sample_from_camera.rotation * lens.unproject({x, y});
      const Eigen::Vector3d& eye = sample_from_camera.translation;
      const Eigen::Vector3d point = eye - ray * (eye.z() / ray.z());
      image.radiance(x, y) = static_cast<float>(value(point.x(), point.y()));
    }
  }
  return image;
}

// Single-precision pictures.
constexpr double float_tolerance = 1e-5;

TEST(White, ScaleAndFlatFieldAreThoseOfTheLight) {
  constexpr double scale = 3.0;  // full scales per second for unit radiance
  constexpr double reflectance = 0.98;
  const auto irradiance = [](double x, double y) {
    return 1.0 + 0.01 * (x - 10.0) - 2e-4 * (y - 8.0) * (y - 8.0);
  };
  const auto white = picture([&](double x, double y) {
    return scale * reflectance * irradiance(x, y) / std::numbers::pi;
  });
  const auto black = picture([&](double x, double y) {
    return 2e-3 * scale * reflectance * irradiance(x, y) / std::numbers::pi;
  });
  const WhiteReference found = measure_white(white, black, reflectance, plain_lens(),
                                             before_lit_face(), block, Face::z_minus, "white");
  EXPECT_NEAR(found.scale[0], scale, float_tolerance * scale);
  EXPECT_NEAR(found.projector_black, 2e-3, 2e-3 * float_tolerance);
  EXPECT_NEAR(found.flat(0.0, 0.0), 1.0, float_tolerance);
  for (const auto& [x, y] : {std::pair{-1.0, -1.0}, std::pair{0.5, 0.9}, std::pair{1.0, 0.0}}) {
    EXPECT_NEAR(found.flat(x, y), irradiance(10.0 + 10.0 * x, 8.0 + 8.0 * y), 10 * float_tolerance);
  }
}

TEST(White, SaturatedTargetIsRefused) {
  auto white = picture([](double, double) { return 1.0; });
  std::fill(white.flags.values().begin(), white.flags.values().end(), capture::pixel_saturated);
  const std::string sentence = sentence_of([&] {
    measure_white(white, std::nullopt, 0.99, plain_lens(), before_lit_face(), block, Face::z_minus,
                  "session.json: calibration.white_target");
  });
  EXPECT_THAT(sentence, HasSubstr("calibration.white_target"));
  EXPECT_THAT(sentence, HasSubstr("add shorter exposures"));
}

/// A chart 18 mm wide and 12 mm high on the lit face, frame as dark as its darkest patch.
double chart_reflectance(double x, double y) {
  const double column = (x - 1.0) / 3.0;
  const double row = (y - 2.0) / 3.0;
  const int i = static_cast<int>(std::floor(column));
  const int j = static_cast<int>(std::floor(row));
  const double u = column - i;
  const double v = row - j;
  if (i < 0 || i > 5 || j < 0 || j > 3 || u < 0.1 || v < 0.1 || u > 0.9 || v > 0.9) return 0.03;
  if (j == 3) return neutral_reflectances()[i];
  return 0.1 + 0.05 * ((i * 7 + j * 3) % 9);
}

/// Where the chart's patches stand in the picture; `turned`: by half a turn.
ChartPatches chart_patches(bool turned) {
  std::array<Eigen::Vector2d, 4> corners;
  const std::array<std::array<double, 2>, 4> centres{
      {{2.5, 3.5}, {17.5, 3.5}, {17.5, 12.5}, {2.5, 12.5}}};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto [x, y] = centres[k];
    const Eigen::Vector3d point =
        turned ? Eigen::Vector3d(20.0 - x, 16.0 - y, 0.0) : Eigen::Vector3d(x, y, 0.0);
    corners[k] = plain_lens().project(before_lit_face() * point);
  }
  return chart_from_corners(corners);
}

TEST(Chart, ItsScaleIsRightUprightAndTurned) {
  constexpr double scale = 2.0;
  const auto at = [](double x, double y) {
    return scale * chart_reflectance(x, y) / std::numbers::pi;
  };
  const auto turned = [&](double x, double y) { return at(20.0 - x, 16.0 - y); };
  for (const bool turn : {false, true}) {
    const auto chart = turn ? picture(turned) : picture(at);
    const ChartReference found = measure_chart(chart, chart_patches(turn), nullptr, 1.0, {});
    ASSERT_EQ(found.scale.size(), 1U);
    EXPECT_NEAR(found.scale[0], scale, 1e-3 * scale);
    EXPECT_LT(found.residual_rms, 1e-3);
  }
}

TEST(Chart, WithTheWhiteTargetUnevenLightDropsOut) {
  constexpr double scale = 2.0;
  const auto light = [](double x) { return 1.0 + 0.03 * (x - 10.0); };
  const auto chart = picture([&](double x, double y) {
    return scale * light(x) * chart_reflectance(x, y) / std::numbers::pi;
  });
  const auto white =
      picture([&](double x, double) { return 0.99 * scale * light(x) / std::numbers::pi; });
  const ChartReference found = measure_chart(chart, chart_patches(false), &white, 0.99, {scale});
  EXPECT_NEAR(found.scale[0], scale, 2e-3 * scale);
  EXPECT_LT(found.residual_rms, 2e-3);
}

TEST(Chart, LuminanceFactorsAreCie) {
  EXPECT_DOUBLE_EQ(luminance_factor(100.0), 1.0);
  EXPECT_NEAR(luminance_factor(50.0), 0.18419, 1e-5);  // CIE 15:2004
  EXPECT_DOUBLE_EQ(luminance_factor(0.0), 0.0);
}

TEST(Footprint, MeansOfALinearPictureAreItsValuesAtVoxelCentres) {
  const auto ramp = [](double x, double y) { return 2.0 + 0.1 * x - 0.05 * y; };
  const auto image = picture(ramp);
  const Footprints footprints =
      make_footprints(plain_lens(), before_lit_face(), block, Face::z_minus);
  for (int v = 0; v < footprints.shape.nv; ++v) {
    for (int u = 0; u < footprints.shape.nu; ++u) {
      const auto voxel = static_cast<std::size_t>(v) * footprints.shape.nu + u;
      ASSERT_EQ(footprints.visible[voxel], 1);
      if (u == 0 || v == 0 || u == block.nx - 1 || v == block.ny - 1) continue;
      double sum = 0.0;
      double weights = 0.0;
      for (std::size_t k = footprints.begin[voxel]; k < footprints.begin[voxel + 1]; ++k) {
        sum += footprints.weight[k] * image.radiance.values()[footprints.pixel[k]];
        weights += footprints.weight[k];
      }
      EXPECT_NEAR(weights, 1.0, float_tolerance);
      EXPECT_NEAR(sum, ramp(u + 0.5, v + 0.5), 2e-4);  // perspective across a voxel
    }
  }
}

TEST(Footprint, RimVoxelsAreNotDarkenedByTheBackground) {
  // An even face of brightness 1 on black: a pixel's value is its covered part.
  const Lens lens = plain_lens();
  const Rigid sample_from_camera = before_lit_face().inverse();
  Image<float> image(lens.width, lens.height, 1);
  constexpr int rays = 10;
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      int hits = 0;
      for (int n = 0; n < rays * rays; ++n) {
        const Eigen::Vector2d at(x + (n % rays + 0.5) / rays - 0.5,
                                 y + (n / rays + 0.5) / rays - 0.5);
        const Eigen::Vector3d ray = sample_from_camera.rotation * lens.unproject(at);
        const Eigen::Vector3d& eye = sample_from_camera.translation;
        const Eigen::Vector3d point = eye - ray * (eye.z() / ray.z());
        hits += point.x() >= 0 && point.y() >= 0 && point.x() <= block.nx && point.y() <= block.ny;
      }
      image(x, y) = static_cast<float>(hits) / (rays * rays);
    }
  }
  const Footprints footprints = make_footprints(lens, before_lit_face(), block, Face::z_minus);
  for (std::size_t voxel = 0; voxel < footprints.shape.cells(); ++voxel) {
    double sum = 0.0;
    for (std::size_t k = footprints.begin[voxel]; k < footprints.begin[voxel + 1]; ++k) {
      sum += footprints.weight[k] * image.values()[footprints.pixel[k]];
    }
    // Coverage by 8 x 8 rays here and 10 x 10 above.
    EXPECT_NEAR(sum * footprints.inverse_coverage[voxel], 1.0, 0.005) << voxel;
  }
}

TEST(Footprint, FaceSeenFromBehindIsInvisible) {
  const Footprints behind = make_footprints(plain_lens(), before_lit_face(), block, Face::z_plus);
  EXPECT_EQ(std::count(behind.visible.begin(), behind.visible.end(), 1), 0);
}

TEST(Irradiance, FollowsThePatternTheFlatFieldAndTheBlackLevel) {
  const Lens projector{640, 480, 2000.0, 2000.0, 320.0, 240.0, {}};
  Rigid projector_from_sample;
  projector_from_sample.translation = {-10.0, -8.0, 200.0};  // 10 projector pixels per mm
  FlatField flat;
  flat.coefficients[1] = 0.1;  // 10 % more at x = +1
  constexpr double black = 1e-3;
  const LitFace lit(projector, projector_from_sample, block, Face::z_minus, flat, black);
  EXPECT_DOUBLE_EQ(lit.reached(), 1.0);
  // The left half of the picture is white: pixels 0 ... 319, its edge at 319.5.
  Image<std::uint16_t> pattern(640, 480, 1);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 320; ++x) pattern(x, y) = 255;
  }
  const LightTable proportional = light_table(std::nullopt);
  const std::vector<float> light = lit.irradiance(pattern, proportional);
  const auto at = [&](int u, int v) { return light[static_cast<std::size_t>(v) * block.nx + u]; };
  EXPECT_NEAR(at(2, 5), 1.0 + 0.1 * (2.0 * 2.5 / 20.0 - 1.0), float_tolerance);
  EXPECT_NEAR(at(15, 5), black * (1.0 + 0.1 * (2.0 * 15.5 / 20.0 - 1.0)), float_tolerance);
  // The edge lies half a pixel, a twentieth of a voxel, inside voxel 9.
  EXPECT_NEAR(at(9, 5), 0.95 * (1.0 - 0.005), 0.02);
  double total = 0.0;
  for (const float e : lit.irradiance(Image<std::uint16_t>(640, 480, 1, 255), proportional))
    total += e;
  EXPECT_NEAR(total / static_cast<double>(light.size()), 1.0, float_tolerance);
}

}  // namespace
}  // namespace kappamu::calib
