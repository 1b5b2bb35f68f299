// Bump, gloss and reflectance of a surface against plain numbers.
#include "render/surface/surface_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "core/mesh/shapes.h"
#include "io/image/image_file.h"
#include "render/render_scene.h"
#include "tests/own_folder.h"
#include "tests/render/made_scene.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

class SurfaceMapsTest : public ::testing::Test {
 protected:
  /// Rises from 0 to 1 to the right and falls back, evenly.
  SurfaceImage roof(const Eigen::Vector2d& size) {
    Image<float> image(64, 4, 1);
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 64; ++x) image(x, y) = (x < 32 ? x : 63 - x) / 31.0F;
    }
    io::write_float_image(folder_ / "roof.exr", image);
    return {folder_ / "roof.exr", size};
  }
  OwnFolder folder_;
};

/// Height 1 to the right over half the image's 8 mm, times 0.5 mm: a slope of 32/31/8.
TEST_F(SurfaceMapsTest, BumpsTiltTheNormalByTheirSlope) {
  SurfaceDetail detail;
  detail.bump = roof({8.0, 8.0});
  detail.depth_mm = 0.5;
  const SurfaceMaps maps(detail, box_mesh({10.0, 10.0, 10.0}, 1));
  const Vector3d up(0.0, 1.0, 0.0), tilted = maps.normal({0, 0.0, 0.0, {2.0, 5.0, 0.3}, up});
  const double slope = 64.0 / 31.0 / 8.0 * 0.5;
  EXPECT_NEAR(-tilted.x() / tilted.y(), slope, 1e-4);
  EXPECT_NEAR(tilted.z(), 0.0, 1e-6);
  const Vector3d back = maps.normal({0, 0.0, 0.0, {6.0, 5.0, 0.3}, up});
  EXPECT_NEAR(back.x(), -tilted.x(), 1e-6);
}

TEST_F(SurfaceMapsTest, GlossMixesRoughnessAndTextureCoordinatesPlaceIt) {
  SurfaceDetail detail;
  detail.gloss = roof({1.0, 1.0});
  detail.gloss->size_mm.reset();
  detail.dull = 0.6;
  detail.glossy = 0.1;
  TriangleMesh mesh = box_mesh({10.0, 10.0, 10.0}, 1);
  EXPECT_THAT(sentence_of([&] { const SurfaceMaps maps(detail, mesh); }, ""),
              ::testing::HasSubstr("no texture coordinates"));
  mesh.texture.resize(mesh.triangles.size(),
                      CornerTexture{Eigen::Vector2f(0.0F, 0.0F), Eigen::Vector2f(1.0F, 0.0F),
                                    Eigen::Vector2f(0.0F, 1.0F)});
  const SurfaceMaps maps(detail, mesh);
  const SurfaceMaps::Place quarter{3, 0.25, 0.5, {1.0, 2.0, 3.0}, Vector3d::UnitX()};
  EXPECT_NEAR(maps.roughness(quarter, 0.9), 0.6 - 0.5 * 15.5 / 31.0, 1e-4);
  EXPECT_EQ(maps.normal(quarter), Vector3d::UnitX());
}

/// Under light along the view the surface adds ρ E/π to what the ball's middle lets out.
TEST_F(SurfaceMapsTest, ReflectanceIsLambertsOnTopOfTheRest) {
  Scene scene = sphere_scene();
  scene.objects[0].finish.eta = 1.0;
  scene.lights.emplace_back(DirectionalLight{-Vector3d::UnitZ(), Colour::Constant(2.0)});
  scene.camera.fov_deg = 0.5;
  KnownAnswer even([](const forward::ObjectProblem&, std::size_t, std::size_t) { return 1.0; });
  Progress progress;
  const RenderResult bare = render_scene(scene, even, {.device = "reference"}, progress);
  scene.objects[0].finish.detail.reflectance = {0.5, 0.25, 0.0};
  const RenderResult coated = render_scene(scene, even, {.device = "reference"}, progress);
  const auto added = [&](int c) {
    return coated.picture.radiance(12, 12, c) - bare.picture.radiance(12, 12, c);
  };
  EXPECT_NEAR(added(0), 0.5 * 2.0 / std::numbers::pi, 1e-3);
  EXPECT_NEAR(added(1), 0.25 * 2.0 / std::numbers::pi, 1e-3);
  EXPECT_NEAR(added(2), 0.0, 1e-6);
}

TEST_F(SurfaceMapsTest, FilesOfASceneAreThoseOfMapsAndMaterials) {
  std::ofstream(folder_ / "glass.mtl") << "newmtl glass\nTf 0.5 0.6 0.7\nNi 1.5\n";
  std::ofstream(folder_ / "scene.json") << R"({"format": "kappamu-scene", "version": 1,
    "objects": [{"name": "ball", "shape": "sphere", "size_mm": 20,
      "material": {"layers": [
        {"thickness_mm": 1, "material": {"file": "glass.mtl", "distance_mm": 3,
                                         "reduced_scattering_per_mm": 1}},
        {"material": {"published": "whole milk"}}]},
      "surface": {"bump": {"image": "b.png", "depth_mm": 0.1, "size_mm": [3, 3]},
                  "gloss": {"image": "g.png", "roughness": [0.5, 0.1], "size_mm": [3, 3]},
                  "reflectance": {"colour": 0.5, "image": "r.png"}}}],
    "lights": [{"kind": "directional", "direction": [0, 0, -1], "irradiance": 1}],
    "camera": {"position_mm": [0, 0, 100], "target_mm": [0, 0, 0], "fov_deg": 20},
    "film": {"width": 16, "height": 16}})";
  const Scene scene = read_scene(folder_ / "scene.json");
  std::vector<std::string> names;
  for (const auto& file : files_of(scene)) names.push_back(file.filename().string());
  EXPECT_THAT(
      names, ::testing::UnorderedElementsAre("scene.json", "glass.mtl", "b.png", "g.png", "r.png"));
}

}  // namespace
}  // namespace kappamu::render
