// What a camera sees of objects whose exitance is known. The models' own answers are tested in
// tests/forward; light on objects in incident_light_test.cpp; what is scattered once on its way to
// the eye in single_scattering_test.cpp.
#include "render/picture/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "render/light/sampling.h"
#include "render/linear_image.h"
#include "render/picture/corner_average.h"
#include "render/render_scene.h"
#include "tests/render/made_scene.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

RenderResult rendered(const Scene& scene, KnownAnswer::Exitance exitance,
                      const RenderOptions& options = {}) {
  KnownAnswer model(std::move(exitance));
  Progress progress;
  return render_scene(scene, model, options, progress);
}

/// Share of even light that a surface sends towards `view`.
double reflectance_of(const Ggx& surface, const Vector3d& view) {
  constexpr int rows = 300, columns = 300;
  double sum = 0.0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double z = (row + 0.5) / rows, angle = 2.0 * pi * (column + 0.5) / columns;
      const double across = std::sqrt(1.0 - z * z);
      const Vector3d light(across * std::cos(angle), across * std::sin(angle), z);
      sum += surface.reflectance(view, light) * 2.0 * pi / (rows * columns);
    }
  }
  return sum;
}

Colour at_centre(const RenderResult& result) {
  const Image<float>& image = result.picture.radiance;
  return pixel(image, image.width() / 2, image.height() / 2);
}

TEST(Picture, KnownExitanceHasItsRefractedRadiance) {
  Scene scene = sphere_scene();
  scene.objects[0].finish.eta = 1.4;
  scene.camera.fov_deg = 0.5;  // the sphere's middle: along the normal
  const RenderResult result = rendered(scene, [](auto&, auto, auto) { return 0.7; });
  const double expected = 0.7 * radiance_per_exitance(boundary_constants(1.4), 1.0);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(at_centre(result)[c], expected, 1e-3 * expected);
  EXPECT_EQ(result.picture.coverage(0, 0), 1.0F);
}

TEST(Picture, ObliqueViewsFollowP1) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].turn_deg = {0.0, 60.0, 0.0};
  scene.objects[0].size_mm = Vector3d(10.0, 10.0, 0.5);
  scene.camera.fov_deg = 0.5;
  const RenderResult result = rendered(scene, [](auto&, auto, auto) { return 1.0; });
  const double expected = radiance_per_exitance(boundary_constants(1.3), 0.5);
  EXPECT_NEAR(at_centre(result)[0], expected, 1e-3 * expected);
}

/// What absorbs nothing, under even light from all sides, is not seen: exitance E_t, refracted out,
/// and reflection add up to what would be there without the object.
constexpr double rounding = 1e-5;  // pictures hold floats

RenderResult furnace(Scene scene) {
  scene.lights.emplace_back(EnvironmentLight{std::nullopt, Colour::Ones(), 0.0, true});
  const double eta = scene.objects[0].finish.eta.value();
  const double transmitted = eta * eta * (1.0 - boundary_constants(eta).r_phi);
  return rendered(
      scene, [&](const forward::ObjectProblem& problem, std::size_t light, std::size_t sample) {
        return transmitted * problem.lights[light].diffuse[sample];
      });
}

TEST(Picture, SmoothNonAbsorbingObjectVanishesInEvenLight) {
  for (const char* shape : {"cube", "sphere"}) {
    for (const double eta : {1.0, 1.5}) {
      Scene scene = sphere_scene();
      scene.objects[0].shape = std::string(shape);
      scene.objects[0].turn_deg = {20.0, 30.0, 0.0};
      scene.objects[0].finish = {eta, 0.0};
      const Image<float> radiance = furnace(scene).picture.radiance;
      for (const float value : radiance.values()) {
        EXPECT_NEAR(value, 1.0, rounding) << shape << ", eta " << eta;
      }
    }
  }
}

/// Light enters and leaves by the smooth surface's transmittance 1 - R, and is reflected by the
/// rough one's facets: what their reflectance differs from R by is all that is seen of the object.
TEST(Picture, RoughNonAbsorbingObjectShowsItsReflectanceLessFresnels) {
  constexpr double eta = 1.5;
  for (const double roughness : {0.15, 0.4}) {
    for (const double degrees : {0.0, 75.0}) {
      Scene scene = sphere_scene();
      scene.objects[0].shape = std::string("cube");
      scene.objects[0].turn_deg = {0.0, degrees, 0.0};
      scene.objects[0].size_mm = Vector3d(10.0, 10.0, 0.5);
      scene.objects[0].finish = {eta, roughness};
      scene.camera.fov_deg = 0.5;
      const Image<float> radiance = furnace(scene).picture.radiance;
      double mean = 0.0;
      for (const float value : radiance.values()) mean += value;
      mean /= static_cast<double>(radiance.size());
      const double angle = degrees * pi / 180.0;
      const Vector3d view(std::sin(angle), 0.0, std::cos(angle));
      const double expected =
          1.0 - fresnel_external(eta, view.z()) + reflectance_of(Ggx(eta, roughness), view);
      constexpr double sampling = 1e-3;
      EXPECT_NEAR(mean, expected, sampling) << roughness << " " << degrees;
    }
  }
}

/// Light scattered once is shown in its own direction; what leaves in all directions together stays
/// the model's exitance.
TEST(Picture, SingleScatteringConservesExitance) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].size_mm = Vector3d(40.0, 40.0, 20.0);
  scene.lights.emplace_back(
      DirectionalLight{Vector3d(0.5, 0.2, -1.0).normalized(), Colour::Ones()});
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const LightSources sources = make_light_sources(scene.lights);
  ObjectExitance exitance;
  for (auto& channel : exitance.exitance) channel.assign(world.objects()[0].surface.size(), 0.6);
  const Shading shading(world, sources, nullptr, {exitance});
  Colour sum = Colour::Zero(), along_normal = Colour::Zero();
  constexpr std::uint32_t samples = 16384;
  const Vector3d point(0.3, 0.2, 10.0);
  for (std::uint32_t i = 0; i < samples; ++i) {
    const auto [u, v] = sobol_point(i, 3);
    const Vector3d view = cosine_direction(Vector3d::UnitZ(), u, v);
    sum += pi * shading.seen(point + 5.0 * view, -view, i, 11).radiance / samples;
    along_normal +=
        shading.seen(point + Vector3d(0, 0, 5), -Vector3d::UnitZ(), i, 12).radiance / samples;
  }
  const double p1 = 0.6 * radiance_per_exitance(boundary_constants(1.3), 1.0);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sum[c], 0.6, 0.005);                   // three standard errors of the sum
    EXPECT_GT(std::abs(along_normal[c] - p1), 0.002);  // it does change what one camera sees
  }
}

TEST(Picture, EqualSeedsGiveEqualBits) {
  Scene scene = sphere_scene();
  scene.objects[0].finish.roughness = 0.3;
  scene.lights.emplace_back(DirectionalLight{-Vector3d::UnitY(), Colour::Ones()});
  scene.lights.emplace_back(EnvironmentLight{std::nullopt, Colour::Constant(0.1), 0.0, true});
  const auto answer = [](const forward::ObjectProblem& problem, std::size_t, std::size_t sample) {
    return 1.0 + 0.01 * problem.surface.position[sample].x();
  };
  const RenderResult one = rendered(scene, answer, {"auto", 3});
  const RenderResult same = rendered(scene, answer, {"auto", 3});
  const RenderResult other = rendered(scene, answer, {"auto", 4});
  EXPECT_EQ(one.picture.radiance.values(), same.picture.radiance.values());
  EXPECT_NE(one.picture.radiance.values(), other.picture.radiance.values());
}

TEST(Render, SolvesEqualChannelsOnce) {
  Scene scene = sphere_scene();
  scene.film.samples = 1;
  auto& material = std::get<HomogeneousMaterial>(scene.objects[0].material);
  scene.lights.emplace_back(DirectionalLight{-Vector3d::UnitY(), Colour::Ones()});
  Progress progress;
  KnownAnswer three([](auto&, auto, auto) { return 1.0; });
  render_scene(scene, three, {}, progress);
  EXPECT_EQ(three.solves, 3U);

  material.kappa_mm = Colour::Constant(0.2);
  material.mu_per_mm = Colour::Constant(0.001);
  KnownAnswer grey([](auto&, auto, auto) { return 1.0; });
  const RenderResult result = render_scene(scene, grey, {}, progress);
  EXPECT_EQ(grey.solves, 1U);
  EXPECT_EQ(grey.lights, 1U);
  EXPECT_EQ(result.exitance[2].size(), result.objects[0].samples);

  std::get<DirectionalLight>(scene.lights[0]).irradiance = {1.0, 0.5, 0.5};
  KnownAnswer coloured([](auto&, auto, auto) { return 1.0; });
  render_scene(scene, coloured, {}, progress);
  EXPECT_EQ(coloured.solves, 1U);
  EXPECT_EQ(coloured.lights, 2U);
}

TEST(CornerAverage, KeepsCreasesAndConstants) {
  Scene scene = sphere_scene();
  scene.objects[0].shape = std::string("cube");
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const WorldObject& cube = world.objects()[0];
  const CornerAverage average(cube.mesh, cube.surface);
  const auto normals = average.of<Vector3d>(
      Vector3d::Zero(), [&](std::size_t t) -> Vector3d { return cube.surface.normal[t]; });
  for (std::size_t t = 0; t < normals.size(); ++t) {
    for (const Vector3d& corner : normals[t]) {
      EXPECT_NEAR((corner - cube.surface.normal[t]).norm(), 0.0, 1e-12);
    }
  }
}

TEST(CornerAverage, SharedCornersHaveTheSameValuesOnce) {
  Scene scene = sphere_scene();
  for (const char* shape : {"cube", "sphere", "cylinder"}) {
    scene.objects[0].shape = std::string(shape);
    std::vector<std::string> warnings;
    const World world(scene, warnings);
    const WorldObject& object = world.objects()[0];
    const CornerAverage average(object.mesh, object.surface);
    const auto value = [&](std::size_t t) { return object.surface.position[t]; };
    const Vector3d zero = Vector3d::Zero();
    const auto corners = average.of<Vector3d>(zero, value);
    const SharedCorners shared = average.shared();
    const auto once = average.of<Vector3d>(shared, zero, value);
    ASSERT_EQ(shared.of_triangle.size(), corners.size());
    for (std::size_t t = 0; t < corners.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t first = shared.first[shared.of_triangle[t][k]];
        EXPECT_EQ(corners[t][k], once[shared.of_triangle[t][k]]) << shape << " " << t;
        EXPECT_EQ(object.mesh.triangles[t][k], object.mesh.triangles[first / 3][first % 3]);
      }
    }
    // A smooth vertex has one, those of a cube's edges two and its corners three.
    const std::size_t vertices = object.mesh.vertices.size();
    if (std::string(shape) == "sphere") {
      EXPECT_EQ(once.size(), vertices);
    } else {
      EXPECT_GT(once.size(), vertices);
      EXPECT_LT(once.size(), 2 * vertices);
    }
  }
}

TEST(Ggx, ReflectsNoMoreThanArrivesAndItsSamplesHaveTheirDensity) {
  for (const double roughness : {0.1, 0.4, 1.0}) {
    const Ggx surface(1.5, roughness);
    for (const double cosine : {1.0, 0.6, 0.2}) {
      const Vector3d view(std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
      double by_samples = 0.0, by_quadrature = 0.0, probability = 0.0;
      constexpr std::uint32_t samples = 4096;
      for (std::uint32_t i = 0; i < samples; ++i) {
        const auto [u, v] = sobol_point(i, 1);
        const Vector3d light = surface.sample(view, u, v);
        const double density = surface.density(view, light);
        if (density > 0.0) by_samples += surface.reflectance(view, light) / density / samples;
      }
      constexpr int rows = 400, columns = 400;
      for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
          const double z = (row + 0.5) / rows, angle = 2.0 * pi * (column + 0.5) / columns;
          const double across = std::sqrt(1.0 - z * z);
          const Vector3d light(across * std::cos(angle), across * std::sin(angle), z);
          by_quadrature += surface.reflectance(view, light) * 2.0 * pi / (rows * columns);
          probability += surface.density(view, light) * 2.0 * pi / (rows * columns);
          const double back = surface.reflectance(light, view);  // reciprocity: f cosθ of each
          EXPECT_NEAR(surface.reflectance(view, light) * view.z(), back * z, 1e-9 * (1.0 + back));
        }
      }
      EXPECT_NEAR(by_samples, by_quadrature, 0.02 * by_quadrature) << roughness << " " << cosine;
      EXPECT_LE(by_quadrature, 1.0);
      EXPECT_LE(probability, 1.01);
    }
  }
}

TEST(Ggx, SmoothSurfaceReflectsFresnel) {
  const Ggx surface(1.5, 0.01);
  const Vector3d view(0.6, 0.0, 0.8);
  double sum = 0.0;
  for (std::uint32_t i = 0; i < 256; ++i) {
    const auto [u, v] = sobol_point(i, 1);
    const Vector3d light = surface.sample(view, u, v);
    sum += surface.reflectance(view, light) / surface.density(view, light) / 256.0;
  }
  EXPECT_NEAR(sum, fresnel_external(1.5, 0.8), 1e-3);
}

TEST(ToneCurve, IsLinearBelowItsShoulderAndNeverClips) {
  Image<float> radiance(4, 1, 3, 0.0F);
  for (int x = 0; x < 4; ++x) {
    for (int c = 0; c < 3; ++c) radiance(x, 0, c) = std::array{0.1F, 0.25F, 5.0F, 500.0F}[x];
  }
  radiance(2, 0, 1) = 1.0F;
  const Image<std::uint8_t> image = tone_mapped(radiance, 2.0);
  EXPECT_EQ(image(0, 0, 0), std::lround(255.0 * srgb_encoded(0.2)));
  EXPECT_EQ(image(1, 0, 0), std::lround(255.0 * srgb_encoded(0.5)));
  EXPECT_NEAR(srgb_decoded(image(2, 0, 1) / 255.0) / srgb_decoded(image(2, 0, 0) / 255.0), 0.2,
              0.01);
  EXPECT_EQ(image(3, 0, 0), 255);
}

}  // namespace
}  // namespace kappamu::render
