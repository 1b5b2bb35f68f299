// Light on objects against closed forms and quadrature. What models do with it is tested with them.
#include "render/light/incident_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/random.h"
#include "io/image/image_file.h"
#include "tests/own_folder.h"
#include "tests/render/made_scene.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

IncidentLight light_of(const Scene& scene, std::size_t object = 0, std::uint64_t seed = 1) {
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const LightSources sources = make_light_sources(scene.lights);
  const auto environment = make_environment(scene.lights);
  Progress progress;
  return incident_light(world, object, sources, environment ? &*environment : nullptr, seed,
                        progress);
}

/// A sphere of flat triangles inscribed in the true one: 64 edges to a quarter circle.
constexpr double tessellation_error = 1e-3;

TEST(IncidentLight, PointLightGivesTheSphereItsSolidAngle) {
  Scene scene = sphere_scene();
  const double radius = 10.0, distance = 40.0, at = 30.0;
  PointLight light{{0.0, distance, 0.0}, {1.0, 0.5, 0.0}, at};
  scene.lights.emplace_back(light);
  const double cone = std::asin(radius / distance);
  const double expected = at * at * 2.0 * pi * (1.0 - std::cos(cone));
  const IncidentLight incident = light_of(scene);
  EXPECT_NEAR(incident.power[0], expected, tessellation_error * expected);
  EXPECT_NEAR(incident.power[1], 0.5 * expected, tessellation_error * expected);
  EXPECT_EQ(incident.power[2], 0.0);
  EXPECT_TRUE(incident.channels[2].beams.empty());
  for (const forward::Beam& beam : incident.channels[0].beams) {
    // To a triangle's edge of the horizon.
    EXPECT_GE(beam.position.y(), radius * radius / distance - 0.25);
  }
}

TEST(IncidentLight, DirectionalLightGivesTheSphereItsDisc) {
  Scene scene = sphere_scene();
  scene.objects[0].turn_deg = {20.0, 30.0, 40.0};
  scene.objects[0].position_mm = {5.0, -3.0, 2.0};
  const Vector3d direction = Vector3d(1.0, -2.0, 0.5).normalized();
  scene.lights.emplace_back(DirectionalLight{direction, Colour::Ones()});
  const IncidentLight incident = light_of(scene);
  EXPECT_NEAR(incident.power[0], pi * 100.0, tessellation_error * pi * 100.0);
  // Directions are in the object's frame, and arrive from its lit side.
  Vector3d mean = Vector3d::Zero();
  for (const forward::Beam& beam : incident.channels[0].beams) {
    mean += beam.power * beam.position;
  }
  const Vector3d in_object = incident.channels[0].beams[0].direction;
  EXPECT_GT(mean.normalized().dot(-in_object), 0.999);
}

TEST(IncidentLight, AnObjectShadowsWhatIsBehindIt) {
  Scene scene = sphere_scene();
  SceneObject plate = scene.objects[0];
  plate.name = "plate";
  plate.shape = std::string("cube");
  plate.size_mm = Vector3d(50.0, 2.0, 50.0);
  plate.position_mm = {0.0, -20.0, 0.0};
  scene.objects.push_back(plate);
  scene.lights.emplace_back(DirectionalLight{-Vector3d::UnitY(), Colour::Ones()});
  const double lit = 50.0 * 50.0 - pi * 100.0;
  // Beams stand half a free path apart: the shadow's edge crosses some 400 of 45,000.
  const IncidentLight incident = light_of(scene, 1);
  EXPECT_NEAR(incident.power[0], lit, 2e-3 * lit);
  for (const forward::Beam& beam : incident.channels[0].beams) {
    EXPECT_GT(std::hypot(beam.position.x(), beam.position.z()), 9.9);
  }
}

TEST(IncidentLight, SpotLightsItsConeAlone) {
  Scene scene = sphere_scene();
  SpotLight spot;
  spot.point = {{0.0, 0.0, 100.0}, Colour::Ones(), 90.0};
  spot.cone_deg = 4.0;
  spot.edge_deg = 0.0;
  scene.lights.emplace_back(spot);
  const double expected = 90.0 * 90.0 * 2.0 * pi * (1.0 - std::cos(2.0 * pi / 180.0));
  EXPECT_NEAR(light_of(scene).power[0], expected, 0.01 * expected);
}

class Projected : public testing::Test {
 protected:
  void SetUp() override {
    Image<std::uint8_t> image(8, 4, 3, 0);
    image(6, 1, 0) = 255;  // red: column 6, row 1
    io::write_image(file_, image);
  }
  const OwnFolder folder_;
  const std::filesystem::path file_ = folder_ / "projected.png";
};

TEST_F(Projected, PixelsLandWhereTheyShould) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].size_mm = Vector3d(80.0, 40.0, 1.0);
  ProjectorLight projector;
  projector.point = {{0.0, 0.0, 100.5}, Colour::Constant(2.0), 100.0};
  projector.fov_deg = 2.0 * std::atan(0.2) * 180.0 / pi;  // the plate's height from 100 mm
  projector.image = file_;
  scene.lights.emplace_back(projector);
  const IncidentLight incident = light_of(scene);
  // Seen along −z with y up, x points right: a pixel is 10 mm, even on the plate.
  EXPECT_NEAR(incident.power[0], 2.0 * 100.0, 0.02 * 200.0);
  EXPECT_EQ(incident.power[1], 0.0);
  for (const forward::Beam& beam : incident.channels[0].beams) {
    EXPECT_GE(beam.position.x(), 20.0 - 1e-6);
    EXPECT_LE(beam.position.x(), 30.0 + 1e-6);
    EXPECT_GE(beam.position.y(), -1e-6);
    EXPECT_LE(beam.position.y(), 10.0 + 1e-6);
  }
}

TEST(IncidentLight, ConstantSurroundingsGivePiTimesTheirRadiance) {
  Scene scene = sphere_scene();
  scene.lights.emplace_back(EnvironmentLight{std::nullopt, {0.3, 0.2, 0.1}, 0.0, true});
  const IncidentLight incident = light_of(scene);
  // Drawn by the cosine alone, without noise on a convex body; the sphere's mesh has a few hollow
  // edges, over which some rays meet the neighbour.
  for (const double irradiance : incident.channels[0].diffuse) {
    ASSERT_LE(irradiance, 0.3 * pi + 1e-6);
    ASSERT_GE(irradiance, 0.9 * 0.3 * pi);
  }
  EXPECT_NEAR(incident.power[2], 0.1 * pi * 4.0 * pi * 100.0, 3e-3 * 0.1 * pi * 4.0 * pi * 100.0);
}

class SkyImage : public testing::Test {
 protected:
  void SetUp() override {
    Image<float> sky(32, 16, 3, 0.1F);
    for (int y = 2; y < 4; ++y) {
      for (int x = 20; x < 23; ++x) sky(x, y, 0) = 50.0F;
    }
    sky(5, 12, 1) = 200.0F;
    io::write_float_image(file_, sky);
    light_.image = file_;
    light_.radiance = {1.0, 0.5, 2.0};
    light_.turn_deg = 37.0;
  }
  const OwnFolder folder_;
  const std::filesystem::path file_ = folder_ / "sky.exr";
  EnvironmentLight light_;
};

// Cube maps and light probes have other shapes; read as latitude and longitude they light wrongly.
TEST_F(SkyImage, OtherShapesAreRefused) {
  io::write_float_image(file_, Image<float>(32, 32, 3, 1.0F));
  EXPECT_THAT(sentence_of([&] { Environment{light_}; }),
              testing::HasSubstr("sky.exr: is 32 x 32 pixels; a latitude-longitude environment"));
}

TEST_F(SkyImage, SamplesHaveTheDensityTheyState) {
  const Environment sky(light_);
  for (int i = 0; i < 1000; ++i) {
    const auto [u, v] = sobol_point(static_cast<std::uint32_t>(i), 5);
    const Environment::Sample sample = sky.sample(u, v);
    EXPECT_NEAR(sample.direction.norm(), 1.0, 1e-12);
    EXPECT_NEAR(sky.density(sample.direction), sample.density, 1e-9 * sample.density);
    EXPECT_TRUE(sky.radiance(sample.direction).isApprox(sample.radiance, 1e-12));
  }
}

TEST_F(SkyImage, IrradianceIsUnbiasedAgainstQuadrature) {
  Scene scene = sphere_scene();
  scene.lights.emplace_back(light_);
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const Environment sky(light_);
  const IncidentLight incident = light_of(scene);
  const Surface& surface = world.objects()[0].surface;
  const double entering_of_even = 1.3 * 1.3 * (1.0 - boundary_constants(1.3).r_phi);
  Colour sum = Colour::Zero(), expected = Colour::Zero();
  // Midpoints of 12 x 12 parts of each pixel: on a convex body nothing is in the way.
  for (std::size_t t = 0; t < surface.size(); t += 997) {
    constexpr int width = 32, height = 16, parts = 12;
    for (int row = 0; row < height * parts; ++row) {
      const int pixel_row = row / parts;
      const double top = std::cos(pi * pixel_row / height);
      const double bottom = std::cos(pi * (pixel_row + 1) / height);
      const double y = top + (bottom - top) * (row % parts + 0.5) / parts;
      const double across = std::sqrt(1.0 - y * y);
      const double weight = (top - bottom) / parts * 2.0 * pi / (width * parts);
      for (int column = 0; column < width * parts; ++column) {
        const double angle =
            2.0 * pi * ((column + 0.5) / (width * parts) - 0.5) - light_.turn_deg * pi / 180.0;
        const Vector3d direction(across * std::sin(angle), y, -across * std::cos(angle));
        const double cosine = surface.normal[t].dot(direction);
        if (cosine <= 0.0) continue;
        const double entering = (1.0 - fresnel_external(1.3, cosine)) / entering_of_even;
        expected += sky.radiance(direction) * cosine * weight * entering;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      sum[static_cast<Eigen::Index>(c)] += incident.channels[c].diffuse[t];
    }
  }
  // Some 30 triangles of about 60 pairs of rays each.
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], expected[c], 0.02 * expected[c]) << c;
}

// What is stated is the even light of which as much enters: of light from above, more than arrives.
TEST(IncidentLight, FresnelWeighsTheDirectionsOfSurroundings) {
  const OwnFolder folder;
  constexpr int rows = 16;
  Image<float> sky(32, rows, 3, 0.0F);
  for (int x = 0; x < 32; ++x) sky(x, 0, 0) = 1.0F;
  io::write_float_image(folder / "sky.exr", sky);
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  EnvironmentLight light;
  light.image = folder / "sky.exr";
  light.radiance = Colour::Ones();
  scene.lights.emplace_back(light);
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const Surface& surface = world.objects()[0].surface;
  const IncidentLight incident = light_of(scene);
  double sum = 0.0, area = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    if (surface.normal[t].y() < 0.9) continue;
    sum += surface.area[t] * incident.channels[0].diffuse[t];
    area += surface.area[t];
  }
  const double arriving = pi * std::pow(std::sin(pi / rows), 2);
  const double middle = std::cos(pi / rows / std::numbers::sqrt2);
  const double of_even = 1.3 * 1.3 * (1.0 - boundary_constants(1.3).r_phi);
  const double expected = arriving * (1.0 - fresnel_external(1.3, middle)) / of_even;
  EXPECT_GT(expected, 1.03 * arriving);
  EXPECT_NEAR(sum / area, expected, 0.01 * expected);
}

TEST(IncidentLight, EqualSeedsGiveEqualBits) {
  Scene scene = sphere_scene();
  scene.lights.emplace_back(DirectionalLight{-Vector3d::UnitY(), Colour::Ones()});
  scene.lights.emplace_back(EnvironmentLight{std::nullopt, Colour::Ones(), 0.0, true});
  const IncidentLight one = light_of(scene, 0, 7), same = light_of(scene, 0, 7),
                      other = light_of(scene, 0, 8);
  EXPECT_EQ(one.channels[1].diffuse, same.channels[1].diffuse);
  EXPECT_NE(one.channels[1].diffuse, other.channels[1].diffuse);
  ASSERT_EQ(one.channels[0].beams.size(), same.channels[0].beams.size());
  for (std::size_t i = 0; i < one.channels[0].beams.size(); ++i) {
    ASSERT_EQ(one.channels[0].beams[i].position, same.channels[0].beams[i].position);
    ASSERT_EQ(one.channels[0].beams[i].power, same.channels[0].beams[i].power);
  }
}

}  // namespace
}  // namespace kappamu::render
