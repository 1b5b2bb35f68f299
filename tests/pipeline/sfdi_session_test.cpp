// Maps from surface measurements under sinusoids: light is found among other patterns, and the
// table's own reflectances give the coefficients back.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "calib/sinusoid/face_waves.h"
#include "core/optics.h"
#include "core/random.h"
#include "pipeline/sfdi/session_maps.h"
#include "tests/sentence.h"

namespace kappamu::pipeline::sfdi {
namespace {

constexpr double face_index = 1.4, face_g = 0.8, face_mua = 0.04, face_musp = 1.8;
constexpr double face_voxel = 0.5;

struct FaceLight {
  double per_mm, degrees, phase;  ///< 0 /mm: a bar
};

/// Three phases of 0.1 and 0.2 /mm along u and of 0.2 /mm at 60 degrees, a bar among them.
std::vector<FaceLight> face_lights() {
  std::vector<FaceLight> lights;
  for (const auto& [per_mm, degrees] :
       {std::pair{0.1, 0.0}, std::pair{0.2, 0.0}, std::pair{0.2, 60.0}}) {
    for (const double phase : {0.0, 120.0, 240.0}) lights.push_back({per_mm, degrees, phase});
    if (degrees == 0.0 && per_mm == 0.1) lights.push_back({0.0, 0.0, 0.0});
  }
  return lights;
}

/// Exitance of a half-space with white noise of `noise`, relative.
SurfaceMeasurements measured_face(double noise) {
  SurfaceMeasurements m;
  m.grid = {48, 40, 40, face_voxel};
  m.eta = face_index;
  m.lit_face = m.seen_face = Face::z_minus;
  m.channels = {"G"};
  const forward::LateralReflectance model({face_index, face_g, 20.0});
  const double entered = boundary_constants(face_index).normal_transmittance;
  const double even = entered * model(0.0, face_mua, face_musp).reflectance;
  std::uint64_t draws = 0;
  for (const FaceLight& light : face_lights()) {
    ++m.patterns;
    const double angle = light.degrees * std::numbers::pi / 180.0;
    const double wave =
        light.per_mm > 0.0 ? entered * model(light.per_mm, face_mua, face_musp).reflectance : 0.0;
    for (int v = 0; v < 40; ++v) {
      for (int u = 0; u < 48; ++u) {
        const double along = face_voxel * (u * std::cos(angle) + v * std::sin(angle));
        const double cosine =
            std::cos(2.0 * std::numbers::pi * (light.per_mm * along + light.phase / 360.0));
        const double shade = 1.0 - 0.004 * u;  // the light falls off to one side
        const bool bar = light.per_mm == 0.0;
        const double lit = bar ? (u < 12 ? 1.0 : 0.0) : 0.5 * shade * (1.0 + cosine);
        const double out = bar ? even * lit : 0.5 * shade * (even + wave * cosine);
        const double white = std::sqrt(12.0) * (uniform(key_of({7, ++draws})) - 0.5);
        m.irradiance.push_back(static_cast<float>(lit));
        m.value.push_back(static_cast<float>(out * (1.0 + noise * white)));
        m.variance.push_back(static_cast<float>(std::pow(std::max(noise, 1e-4) * out, 2) + 1e-12));
      }
    }
  }
  return m;
}

TEST(SfdiSession, SinusoidsAreFoundByTheirLight) {
  const std::vector<calib::FaceWave> waves = calib::face_waves(measured_face(0.0));
  ASSERT_EQ(waves.size(), 3U);
  EXPECT_EQ(waves[0].patterns, (std::vector<int>{0, 1, 2}));
  EXPECT_NEAR(waves[0].carrier.frequency() / face_voxel, 0.1, 1e-3);
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_NEAR(waves[i].carrier.frequency() / face_voxel, 0.2, 1e-3);
    EXPECT_EQ(waves[i].patterns.size(), 3U);
  }
}

TEST(SfdiSession, CoefficientsComeBackWithTheirDeviations) {
  const SurfaceMeasurements m = measured_face(0.002);
  const SessionMaps made = maps_of_measurements(m, {face_g, {}, {}}, "made up");
  ASSERT_EQ(made.maps.wavelengths.size(), 1U);
  const WavelengthMap& map = made.maps.wavelengths.front();
  EXPECT_EQ(map.name, "G");
  const RegionMean& region = map.region.value();
  EXPECT_NEAR(region.mean.mua / face_mua, 1.0, 0.01);
  EXPECT_NEAR(region.mean.musp / face_musp, 1.0, 0.005);
  const auto noise = map.parts[static_cast<std::size_t>(Part::noise)];
  // Noise that grows with light is shared by mean and wave, which the deviation does not count on.
  for (const double ratio :
       {region.spread[0] / (noise[0] * face_mua), region.spread[1] / (noise[1] * face_musp)}) {
    EXPECT_GT(ratio, 0.5);
    EXPECT_LT(ratio, 1.2);
  }
}

TEST(SfdiSession, RefusesInOneSentence) {
  const auto refusal = [](const SurfaceMeasurements& m) {
    return sentence_of([&] { maps_of_measurements(m, {face_g, {}, {}}, "here"); });
  };
  SurfaceMeasurements through = measured_face(0.0);
  through.seen_face = Face::z_plus;
  EXPECT_NE(refusal(through).find("here: the lit face is not the seen one"), std::string::npos);
  SurfaceMeasurements clear = measured_face(0.0);
  clear.eta = 1.2;
  EXPECT_NE(refusal(clear).find("here: refractive index 1.2 is outside the table"),
            std::string::npos);
  SurfaceMeasurements dark = measured_face(0.0);
  std::fill(dark.irradiance.begin(), dark.irradiance.end(), 0.5F);
  EXPECT_NE(refusal(dark).find("here: no pattern is a sinusoid"), std::string::npos);
}

}  // namespace
}  // namespace kappamu::pipeline::sfdi
