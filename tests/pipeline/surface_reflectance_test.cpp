// What a lit face sends back beyond its prediction, as a reflectance of its surface.
#include "pipeline/surface_reflectance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/optics.h"
#include "io/image/image_file.h"
#include "tests/own_folder.h"

namespace kappamu::pipeline {
namespace {

constexpr GridShape block{16, 12, 6, 0.5};
constexpr std::size_t cells = 16 * 12;

double reflectance_of(std::size_t pixel) {
  return 0.2 + 0.1 * std::sin(0.7 * static_cast<double>(pixel % 16));
}

/// Both faces under the left half's light and the right half's; the camera looks along the normal.
struct HalvesAndPrediction {
  SurfaceMeasurements measured;
  std::vector<float> prediction;

  HalvesAndPrediction() {
    SurfaceMeasurements& m = measured;
    m.grid = block;
    m.channels = {"R", "G", "B"};
    m.patterns = 4;
    set_seen_faces({Face::z_plus, Face::z_minus, Face::z_plus, Face::z_minus}, m.seen_face,
                   m.seen_faces);
    for (int p = 0; p < 4; ++p) {
      for (std::size_t i = 0; i < cells; ++i)
        m.irradiance.push_back((i % 16 < 8) == (p < 2) ? 0.9F : 0.0F);
    }
    const double towards = radiance_per_exitance(boundary_constants(m.eta), 1.0);
    for (int c = 0; c < 3; ++c) {
      for (int p = 0; p < 4; ++p) {
        for (std::size_t i = 0; i < cells; ++i) {
          const float light = m.irradiance[static_cast<std::size_t>(p) * cells + i];
          const bool lit = p % 2 == 1 && light > 0.0F;
          prediction.push_back(0.01F * static_cast<float>(c + 1));
          const double surface =
              lit ? reflectance_of(i) * light / (std::numbers::pi * towards) : 0.0;
          m.value.push_back(prediction.back() + static_cast<float>(surface));
          m.mask.push_back(lit ? 0 : 1);
          m.lit.push_back(lit ? 1 : 0);
          m.variance.push_back(1e-6F);
        }
      }
    }
  }
};

TEST(SurfaceReflectance, IsWhatThePredictionLeaves) {
  const HalvesAndPrediction of;
  const auto found = surface_reflectance(of.measured, std::array{0, 2},
                                         std::span(of.prediction).first(2 * 4 * cells), {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->face, Face::z_minus);
  EXPECT_EQ(found->measured, 1.0);
  ASSERT_EQ(found->channels.size(), 2U);
  EXPECT_EQ(found->channels[1].name, "B");
  for (std::size_t i = 0; i < cells; ++i) EXPECT_NEAR(found->value[i], reflectance_of(i), 1e-5);
  // Blue is 0.02 above the prediction given for it, red's neighbour, in both pictures.
  const double towards = radiance_per_exitance(boundary_constants(1.3), 1.0);
  EXPECT_NEAR(found->value[cells] - found->value[0], 2 * 0.01 * std::numbers::pi * towards / 0.9,
              1e-5);
  EXPECT_NEAR(found->channels[0].noise, std::numbers::pi * towards / 0.9 * std::sqrt(2e-6), 1e-6);
}

/// A face seen aslant sends less of its scattered light for an exitance, and all of what its
/// surface reflects.
TEST(SurfaceReflectance, KnowsTheAngleOfTheView) {
  const HalvesAndPrediction of;
  Rigid camera;  // 200 mm away, 40 degrees off the normal
  const double angle = 40.0 * std::numbers::pi / 180.0;
  const Eigen::Vector3d eye(4.0 + 200.0 * std::sin(angle), 3.0, -200.0 * std::cos(angle));
  camera.translation = -eye;
  const std::array all{0, 1, 2};
  const auto found = surface_reflectance(of.measured, all, of.prediction, camera);
  ASSERT_TRUE(found);
  const BoundaryConstants optics = boundary_constants(1.3);
  const double factor =
      radiance_per_exitance(optics, std::cos(angle)) / radiance_per_exitance(optics, 1.0);
  EXPECT_LT(factor, 0.97);
  const std::size_t middle = 6 * 16 + 8;
  EXPECT_NEAR(found->value[middle], factor * reflectance_of(middle), 1e-3);
}

TEST(SurfaceReflectance, NeedsEvenLightAndUnsaturatedPixels) {
  const std::array all{0, 1, 2};
  HalvesAndPrediction half;
  for (std::size_t i = 3 * cells; i < 4 * cells; ++i) half.measured.irradiance[i] = 0.0F;
  EXPECT_FALSE(surface_reflectance(half.measured, all, half.prediction, {}));
  HalvesAndPrediction saturated;
  saturated.measured.lit.assign(saturated.measured.lit.size(), 0);
  EXPECT_FALSE(surface_reflectance(saturated.measured, all, saturated.prediction, {}));
  HalvesAndPrediction behind;
  behind.measured.seen_faces.clear();
  behind.measured.seen_face = Face::z_plus;
  EXPECT_FALSE(surface_reflectance(behind.measured, all, behind.prediction, {}));
}

TEST(SurfaceReflectance, IsWrittenFromTheLargestV) {
  const OwnFolder folder;
  SurfaceReflectance one;
  one.face = Face::z_plus;
  one.shape = {2, 2};
  one.value = {0.1F, 0.2F, 0.3F, 0.4F};
  one.channels.resize(1);
  EXPECT_EQ(write_surface_reflectance(folder.path(), one), "reflectance_z+.exr");
  const Image<float> image = io::read_float_image(folder / "reflectance_z+.exr");
  EXPECT_EQ(image(0, 0), 0.3F);
  EXPECT_EQ(image(1, 1), 0.2F);
}

}  // namespace
}  // namespace kappamu::pipeline
