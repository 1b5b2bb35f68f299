// Light scattered once, along one ray of the eye, against closed forms.
#include "render/picture/single_scattering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "render/light/sampling.h"
#include "tests/render/made_scene.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

TEST(SingleScattering, OfAHalfSpaceIsTheClosedForm) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].size_mm = Vector3d(60.0, 60.0, 30.0);  // 60 free paths deep: no far side
  const double cos_light = 0.8;
  scene.lights.emplace_back(DirectionalLight{
      Vector3d(std::sqrt(1.0 - cos_light * cos_light), 0.0, -cos_light), Colour::Constant(2.0)});
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const LightSources sources = make_light_sources(scene.lights);
  const SingleScattering single(world, sources);
  WorldHit hit;
  hit.position = {0.1, 0.2, 15.0};
  hit.normal = Vector3d::UnitZ();
  const double cos_view = 0.7;
  const Vector3d inward(0.0, std::sqrt(1.0 - cos_view * cos_view), -cos_view);
  Colour mean = Colour::Zero();
  constexpr std::uint32_t samples = 4096;
  for (std::uint32_t i = 0; i < samples; ++i) {
    const auto [u, v] = sobol_point(i, 9);
    mean += single.radiance_inside(hit, inward, u, v) / samples;
  }
  const double cos_inside = std::sqrt(1.0 - (1.0 - cos_light * cos_light) / (1.3 * 1.3));
  const double transmitted = 1.0 - fresnel_external(1.3, cos_light);
  for (int c = 0; c < 3; ++c) {
    const auto& material = std::get<HomogeneousMaterial>(scene.objects[0].material);
    const double extinction = 1.0 / (3.0 * material.kappa_mm[c]);
    const double albedo = 1.0 - material.mu_per_mm[c] / extinction;
    const double expected = albedo * 2.0 * transmitted * cos_light / cos_inside / (4.0 * pi) /
                            (1.0 + cos_view / cos_inside);
    EXPECT_NEAR(mean[c], expected, 0.005 * expected);
  }
}

/// Through clear layers behind a dense skin one sees light from the other side: along the normal
/// all depths send alike, and no draw of them stands out.
TEST(SingleScattering, ThroughAnObjectHasNoOutliers) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].size_mm = Vector3d(20.0, 20.0, 4.0);
  scene.lights.emplace_back(DirectionalLight{Vector3d::UnitZ(), Colour::Constant(2.0)});
  std::vector<std::string> warnings;
  World world(scene, warnings);
  const GridShape shape{1, 1, 200, 0.02};
  const auto layers =
      std::make_shared<Medium>(Medium{Volume<double>(shape, 2.0), Volume<double>(shape, 0.01)});
  for (int z = 0; z < shape.nz; ++z) {
    if (z < 50 || z >= 150) layers->kappa(0, 0, z) = 0.1;
  }
  const Eigen::Affine3d place(Eigen::Translation3d(0.5, 0.5, 2.0));
  const auto medium = std::make_shared<ObjectMedium>(layers, place, Wrap::clamp);
  ObjectMedia media = world.objects()[0].media;
  media.channels = {medium, medium, medium};
  world.set_media(0, media);
  const LightSources sources = make_light_sources(scene.lights);
  const SingleScattering single(world, sources);
  WorldHit hit;
  hit.position = {0.1, 0.2, 2.0};
  hit.normal = Vector3d::UnitZ();
  double depth = 0.0, scattering = 0.0;
  for (const double kappa : layers->kappa.values()) {
    depth += shape.voxel_mm / (3.0 * kappa);
    scattering += shape.voxel_mm * (1.0 / (3.0 * kappa) - 0.01);
  }
  const double expected =
      2.0 * (1.0 - fresnel_external(1.3, 1.0)) * scattering * std::exp(-depth) / (4.0 * pi);
  double mean = 0.0, most = 0.0;
  constexpr std::uint32_t samples = 4096;
  for (std::uint32_t i = 0; i < samples; ++i) {
    const auto [u, v] = sobol_point(i, 9);
    const double drawn = single.radiance_inside(hit, -Vector3d::UnitZ(), u, v)[0];
    mean += drawn / samples;
    most = std::max(most, drawn);
  }
  EXPECT_NEAR(mean, expected, 0.01 * expected);
  EXPECT_LT(most, 4.0 * expected);  // 1 / the share of even draws, with room for layers' albedos
}

}  // namespace
}  // namespace kappamu::render
