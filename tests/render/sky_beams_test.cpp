// Lamps of an environment as beams, against the same light as directional sources and closed forms.
#include "render/light/sky_beams.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "io/image/image_file.h"
#include "render/light/incident_light.h"
#include "render/picture/single_scattering.h"
#include "tests/own_folder.h"
#include "tests/render/made_scene.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// A dim sky with a square lamp, 50° wide, about a direction that is low behind a body.
class SkyBeams : public testing::Test {
 protected:
  static constexpr int rows = 36, columns = 72;
  SkyBeams() {
    Image<float> sky(columns, rows, 3, 0.05F);
    for (int y = 14; y < 24; ++y) {
      for (int x = 31; x < 41; ++x) {
        for (int c = 0; c < 3; ++c) sky(x, y, c) = c == 0 ? 3.0F : 2.0F;
      }
    }
    io::write_float_image(folder_ / "sky.exr", sky);
    light_.image = folder_ / "sky.exr";
    light_.radiance = Colour::Ones();
    scene_ = sphere_scene();
    scene_.lights.emplace_back(light_);
  }
  IncidentLight lit(LampsEnter lamps) const {
    std::vector<std::string> warnings;
    const World world(scene_, warnings);
    const Environment sky(light_, lamps);
    Progress progress;
    return incident_light(world, 0, {}, &sky, 1, progress);
  }
  /// Calls act(direction, radiance, solid angle) for the middles of pixels.
  template <class Act>
  void for_pixels(const Environment& sky, const Act& act) const {
    for (int y = 0; y < rows; ++y) {
      const double top = std::cos(pi * y / rows), bottom = std::cos(pi * (y + 1) / rows);
      const double up = 0.5 * (top + bottom), across = std::sqrt(1.0 - up * up);
      for (int x = 0; x < columns; ++x) {
        const double angle = 2.0 * pi * ((x + 0.5) / columns - 0.5);
        const Vector3d towards(across * std::sin(angle), up, -across * std::cos(angle));
        act(towards, sky.radiance(towards), 2.0 * pi / columns * (top - bottom));
      }
    }
  }

  const OwnFolder folder_;
  EnvironmentLight light_;
  Scene scene_;
};

/// Σ power · value(cosine outside) / Σ power.
template <class Value>
double mean_over(const std::vector<forward::Beam>& beams, const Surface& surface,
                 const Value& value) {
  double sum = 0.0, power = 0.0;
  for (const forward::Beam& beam : beams) {
    sum += beam.power *
           value(-beam.direction.dot(surface.normal[static_cast<std::size_t>(beam.triangle)]));
    power += beam.power;
  }
  return sum / power;
}

/// A convex body receives πR² of each direction, whichever way it enters.
TEST_F(SkyBeams, BringAllTheLight) {
  const double radius = 10.0, tessellation = 2e-3;
  Colour expected = Colour::Zero();
  for_pixels(Environment(light_), [&](const Vector3d&, const Colour& radiance, double angle) {
    expected += pi * radius * radius * angle * radiance;
  });
  for (const LampsEnter lamps : {LampsEnter::evenly, LampsEnter::as_beams}) {
    const IncidentLight incident = lit(lamps);
    EXPECT_EQ(incident.channels[0].beams.empty(), lamps == LampsEnter::evenly);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(incident.power[c], expected[c], tessellation * expected[c]) << c;
    }
  }
}

/// How obliquely they arrive, and so how deep they scatter first, is as of a directional light for
/// each of the lamp's pixels.
TEST_F(SkyBeams, ArriveAsTheLampsDirections) {
  std::vector<std::string> warnings;
  const World world(scene_, warnings);
  const Surface& surface = world.objects()[0].surface;
  const Environment sky(light_, LampsEnter::as_beams);
  std::vector<Light> pixels;
  for_pixels(sky, [&](const Vector3d& towards, const Colour&, double angle) {
    const Colour above = sky.of_lamps(towards);
    if (above.maxCoeff() > 0.0) pixels.emplace_back(DirectionalLight{-towards, angle * above});
  });
  ASSERT_EQ(pixels.size(), 100U);
  Progress progress;
  const IncidentLight expected =
      incident_light(world, 0, make_light_sources(pixels), nullptr, 1, progress);
  const IncidentLight incident = lit(LampsEnter::as_beams);
  const auto depth = [](double cosine) {
    return std::sqrt(1.0 - (1.0 - cosine * cosine) / (1.3 * 1.3));
  };
  const double inside = mean_over(incident.channels[0].beams, surface, depth);
  EXPECT_NEAR(inside, mean_over(expected.channels[0].beams, surface, depth), 1e-3);
  // Of even light it would be deeper; the test would see that.
  const auto upwards = [&](double cosine) { return cosine * cosine; };
  EXPECT_NEAR(mean_over(incident.channels[1].beams, surface, upwards),
              mean_over(expected.channels[1].beams, surface, upwards), 2e-3);
  for (const forward::Beam& beam : incident.channels[0].beams) {
    ASSERT_GT(sky.of_lamps(-beam.direction)[0], 0.0);
  }
}

/// Looking along the normal through a slab that scatters little: (1 − R)² e^(−τ) of the lamp.
TEST_F(SkyBeams, ShowLampsThroughClearBodies) {
  scene_.objects[0].shape = std::string("cube");
  scene_.objects[0].size_mm = Vector3d(20.0, 20.0, 3.0);
  HomogeneousMaterial clear;
  clear.kappa_mm = {2.0, 1.0, 0.5};
  clear.mu_per_mm = Colour::Zero();
  scene_.objects[0].material = clear;
  std::vector<std::string> warnings;
  const World world(scene_, warnings);
  const Environment sky(light_, LampsEnter::as_beams);
  const LightSources none;
  const SingleScattering single(world, none);
  WorldHit hit;
  hit.position = {0.1, 0.2, 1.5};
  hit.normal = Vector3d::UnitZ();
  const Colour seen = single.sky_through(hit, -Vector3d::UnitZ(), sky);
  const Colour lamp = sky.of_lamps(-Vector3d::UnitZ());
  const double let_in = 1.0 - fresnel_external(1.3, 1.0);
  for (int c = 0; c < 3; ++c) {
    const double depth = 3.0 / (3.0 * clear.kappa_mm[c]);
    EXPECT_NEAR(seen[c], 1.3 * 1.3 * let_in * lamp[c] * std::exp(-depth), 1e-6) << c;
  }
  // Beside the lamp there is none, nor beyond the critical angle.
  EXPECT_EQ(single.sky_through(hit, Vector3d(0.6, 0.0, -0.8), sky).maxCoeff(), 0.0);
}

}  // namespace
}  // namespace kappamu::render
