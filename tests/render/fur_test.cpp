// Fur on objects: placement without gaps or stretching, light balance, refusals and warnings. What
// light does in a tile is tested in tests/forward/shells.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>

#include "core/mesh/shapes.h"
#include "core/random.h"
#include "io/image/image_file.h"
#include "render/fur/fur_shading.h"
#include "render/fur/live_fur.h"
#include "render/render_scene.h"
#include "tests/render/made_scene.h"
#include "tests/sentence.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

/// A furry ball in the open, small enough to take a second.
Scene furry_scene() {
  Scene scene = sphere_scene();
  scene.objects[0].finish = {1.0, 0.0};
  scene.objects[0].edges_per_size = 24;
  Fur fur;
  fur.length_mm = 2.0;
  fur.rays = 64;
  fur.bands = 4;
  scene.objects[0].fur = fur;
  scene.film = {24, 24, 4, std::nullopt};
  return scene;
}

EnvironmentLight sky(double radiance) {
  return {std::nullopt, Colour::Constant(radiance), 0.0, false};
}

RenderResult rendered_with(const Scene& scene, double exitance) {
  KnownAnswer model([=](auto&, auto, auto) { return exitance; });
  Progress progress;
  return render_scene(scene, model, {}, progress);
}

double sum(const Image<float>& image) {
  return std::accumulate(image.values().begin(), image.values().end(), 0.0);
}

TEST(Placement, CoversEveryPlaceAndStretchesNone) {
  Fur fur;
  fur.comb_turn_deg = 40.0;
  for (const TriangleMesh& mesh :
       {sphere_mesh(10.0, 30), torus_mesh(10.0, 4.0, 50), box_mesh({12.0, 20.0, 7.0}, 30)}) {
    const std::vector<SkinFrame> frames = skin_frames(mesh, fur);
    for (const SkinFrame& frame : frames) {
      EXPECT_LT((frame.transpose() * frame - SkinFrame::Identity()).norm(), 1e-12);
      EXPECT_NEAR(frame.determinant(), 1.0, 1e-12);
    }
    const Placement placement(mesh, frames, 4.0, 3);
    EXPECT_LE(placement.stretch(), 1.5);
    EXPECT_GT(placement.patches(), 10U);
    std::size_t bare = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const double u = uniform(key_of({t, 0})), v = (1.0 - u) * uniform(key_of({t, 1}));
      const Placement::Places places = placement.at(t, u, v);
      double weight = 0.0;
      for (int i = 0; i < places.count; ++i) {
        weight += places.place[static_cast<std::size_t>(i)].weight;
      }
      if (places.count == 0) {
        ++bare;
      } else {
        EXPECT_NEAR(weight, 1.0, 1e-12);
      }
    }
    EXPECT_EQ(bare, 0U);
  }
}

TEST(Placement, IsContinuousAcrossEdges) {
  // The two triangles of an edge give a point of it the same places.
  const TriangleMesh mesh = sphere_mesh(10.0, 30);
  const std::vector<SkinFrame> frames = skin_frames(mesh, Fur{});
  const Placement placement(mesh, frames, 4.0, 3);
  int compared = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t other = t + 1; other < mesh.triangles.size() && compared < 200; ++other) {
      const auto& one = mesh.triangles[t];
      const auto& two = mesh.triangles[other];
      const auto at = [](const std::array<int, 3>& of, int corner) {
        return std::find(of.begin(), of.end(), corner) - of.begin();
      };
      if (at(two, one[0]) == 3 || at(two, one[1]) == 3) continue;
      std::array<double, 3> share{};
      share[static_cast<std::size_t>(at(two, one[0]))] = 0.7;
      share[static_cast<std::size_t>(at(two, one[1]))] = 0.3;
      const auto here = placement.at(t, 0.3, 0.0), there = placement.at(other, share[1], share[2]);
      ++compared;
      ASSERT_EQ(here.count, there.count);
      for (int i = 0; i < here.count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        EXPECT_NEAR(here.place[k].weight, there.place[k].weight, 1e-9);
        EXPECT_LT((here.place[k].tile - there.place[k].tile).norm(), 1e-9);
      }
    }
  }
  EXPECT_EQ(compared, 200);
}

TEST(Fur, OfNoHairsShowsTheSkin) {
  Scene scene = furry_scene();
  scene.lights.emplace_back(sky(1.0));
  scene.objects[0].fur->density = 0.0;
  const RenderResult bald = rendered_with(scene, 0.5);
  scene.objects[0].fur.reset();
  const RenderResult bare = rendered_with(scene, 0.5);
  ASSERT_EQ(bald.picture.radiance.size(), bare.picture.radiance.size());
  for (std::size_t i = 0; i < bare.picture.radiance.size(); ++i) {
    EXPECT_NEAR(bald.picture.radiance.values()[i], bare.picture.radiance.values()[i], 1e-5);
  }
  EXPECT_EQ(bald.objects[0].fur->through, 1.0);
}

TEST(Fur, LeavesTheSkinWhatItReports) {
  Scene scene = furry_scene();
  scene.objects[0].finish = {1.3, 0.0};
  scene.objects[0].fur->density = 0.1;
  scene.lights.emplace_back(sky(1.0));
  const RenderResult furry = rendered_with(scene, 0.5);
  const double through = furry.objects[0].fur->through;
  EXPECT_GT(through, 0.01);
  EXPECT_LT(through, 0.9);
  scene.objects[0].fur.reset();
  const RenderResult bare = rendered_with(scene, 0.5);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(furry.objects[0].channels[c].power_in,
                through * bare.objects[0].channels[c].power_in, 1e-9);
  }
}

TEST(Fur, OfWhiteHairIsNoBrighterThanTheSky) {
  Scene scene = furry_scene();
  scene.lights.emplace_back(sky(1.0));
  Fur& fur = *scene.objects[0].fur;
  fur.root_colour = fur.tip_colour = Colour::Ones();
  fur.variation = 0.0;
  // Light scattered once: half the sky at most, as the skin hides the rest; five per cent for the
  // bands' overshoot.
  const Image<float> radiance = rendered_with(scene, 0.0).picture.radiance;
  const float most = *std::max_element(radiance.values().begin(), radiance.values().end());
  EXPECT_LT(most, 0.55F);
  EXPECT_GT(most, 0.2F);
}

TEST(Fur, IsLitAlikeFromAllSides) {
  // A ball seen from the front: a lamp at the left, right, above and below gives as much light.
  std::vector<double> light;
  for (const Vector3d& from :
       {Vector3d(1, 0, 0.5), Vector3d(-1, 0, 0.5), Vector3d(0, 1, 0.5), Vector3d(0, -1, 0.5)}) {
    Scene scene = furry_scene();
    scene.objects[0].fur->lean = 0.0;
    scene.lights.emplace_back(DirectionalLight{-from.normalized(), Colour::Ones()});
    light.push_back(sum(rendered_with(scene, 0.0).picture.radiance));
  }
  // Patches lie at random; a few dozen of them are lit.
  for (const double one : light) EXPECT_NEAR(one, light[0], 0.05 * light[0]);
}

TEST(Fur, FinsAddHairAtTheSilhouetteAlone) {
  Scene scene = furry_scene();
  scene.lights.emplace_back(sky(1.0));
  scene.film = {48, 48, 4, std::nullopt};
  const Image<float> with = rendered_with(scene, 0.0).picture.coverage;
  scene.objects[0].fur->fins = false;
  const Image<float> without = rendered_with(scene, 0.0).picture.coverage;
  EXPECT_GT(sum(with), sum(without));
  for (int y = 16; y < 32; ++y) {
    for (int x = 16; x < 32; ++x) EXPECT_EQ(with(x, y), without(x, y));
  }
}

TEST(Fur, RefusesATileSmallerThanTheMesh) {
  Scene scene = furry_scene();
  scene.lights.emplace_back(sky(1.0));
  scene.objects[0].fur->length_mm = 0.2;
  EXPECT_THAT(sentence_of([&] { rendered_with(scene, 0.0); }),
              testing::HasSubstr("object 'ball': fur: tile_mm"));
}

TEST(Fur, WarnsOfWhatShellsCannotShow) {
  const auto warnings = [](const Scene& scene) { return rendered_with(scene, 0.0).warnings; };
  Scene scene = furry_scene();
  scene.film = {2, 2, 1, std::nullopt};
  scene.lights.emplace_back(sky(1.0));
  const auto says = [](const char* text) { return testing::Contains(testing::HasSubstr(text)); };
  EXPECT_THAT(warnings(scene), testing::Not(says("fur:")));
  scene.objects[0].fur->density = 6.0;
  EXPECT_THAT(warnings(scene), says("full already"));
  scene.objects[0].fur->density = 1.0;
  scene.objects[0].fur->width = 0.2;
  EXPECT_THAT(warnings(scene), says("thinner than a tenth of a texel"));
  scene.objects[0].fur->width = 1.0;
  scene.lights.emplace_back(DirectionalLight{-Vector3d::UnitY(), Colour::Ones()});
  EXPECT_THAT(warnings(scene), says("sharper than 4 bands"));
  // A plate seen along its face.
  scene.objects[0].shape = std::string("cube");
  scene.objects[0].size_mm = Vector3d(20.0, 1.0, 20.0);
  scene.camera.position_mm = Vector3d(0.0, 4.0, 100.0);
  EXPECT_THAT(warnings(scene), says("less than 14 degrees"));
}

/// A ball whose u runs along x and v along y, 0 to 1.
TriangleMesh textured_ball() {
  TriangleMesh mesh = sphere_mesh(10.0, 30);
  for (const auto& t : mesh.triangles) {
    CornerTexture corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector3d& at = mesh.vertices[static_cast<std::size_t>(t[c])];
      corners[c] = {static_cast<float>(0.5 + 0.049 * at.x()),
                    static_cast<float>(0.5 + 0.049 * at.y())};
    }
    mesh.texture.push_back(corners);
  }
  return mesh;
}

/// Black on the left, white on the right.
std::filesystem::path halves(const std::string& name) {
  Image<std::uint8_t> image(64, 8, 3);
  for (int y = 0; y < 8; ++y) {
    for (int x = 32; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = 255;
    }
  }
  const std::filesystem::path file = std::filesystem::temp_directory_path() / name;
  io::write_image(file, image);
  return file;
}

TEST(Coat, IsReadWhereTheMapHasIt) {
  const TriangleMesh mesh = textured_ball();
  Fur fur;
  fur.length_map = fur.density_map = fur.colour_map = fur.comb_map = halves("fur_halves.png");
  const Coat coat = coat_of(mesh, fur);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double x = mesh.vertices[v].x();
    if (std::abs(x) < 0.5) continue;
    const float there = x > 0.0 ? 1.0F : 0.0F;
    EXPECT_EQ(coat.length[v], there);
    EXPECT_EQ(coat.density[v], there);
    EXPECT_EQ(coat.colour[v][1], there);
    // White is along and across alike, black is the opposite.
    EXPECT_NEAR(coat.turn[v], (x > 0.0 ? 0.25 : -0.75) * std::numbers::pi, 1e-6);
  }
  fur = {};
  const std::vector<SkinFrame> bare = skin_frames(mesh, fur), turned = skin_frames(mesh, fur, coat);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.vertices[v].x() < 0.5) continue;
    EXPECT_NEAR(turned[v].col(0).dot(bare[v].col(1)), std::sqrt(0.5), 1e-6);
  }
}

/// Strokes drawn while they grow, some taken back, are those drawn at once, to the last bit.
TEST(Coat, IsTheSameStrokeByStroke) {
  const TriangleMesh mesh = sphere_mesh(5.0, 24);
  Fur fur;
  FurStroke comb{FurStroke::Of::comb, {}, 3.0}, colour{FurStroke::Of::colour, {}, 2.0};
  colour.colour = {0.1, 1.0, 0.2};
  const auto on_ball = [](double angle) {
    return Vector3d(5.0 * std::sin(angle), 0.3, 5.0 * std::cos(angle));
  };
  CoatPainter painter(mesh, fur);
  fur.strokes = {comb};
  fur.strokes[0].points_mm = {on_ball(0.0), on_ball(0.1)};
  for (int i = 2; i < 9; ++i) {
    fur.strokes[0].points_mm.push_back(on_ball(0.1 * i));
    painter.of(fur);
  }
  const Fur combed = fur;
  fur.strokes.push_back(colour);
  fur.strokes[1].points_mm = {on_ball(0.5), on_ball(0.6), on_ball(0.7)};
  painter.of(fur);
  const auto expect_same = [](const Coat& a, const Coat& b) {
    EXPECT_EQ(a.length, b.length);
    EXPECT_EQ(a.density, b.density);
    EXPECT_EQ(a.turn, b.turn);
    for (std::size_t v = 0; v < a.colour.size(); ++v) {
      EXPECT_TRUE((a.colour[v] == b.colour[v]).all()) << v;
    }
  };
  const Coat both = coat_of(mesh, fur);
  expect_same(painter.of(fur), both);
  expect_same(painter.of(combed), coat_of(mesh, combed));
  expect_same(painter.of(fur), both);
  // Combed along the stroke where it went; elsewhere the coat is as it was.
  const std::vector<SkinFrame> frames = skin_frames(mesh, fur, both);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if ((mesh.vertices[v] - on_ball(0.4)).norm() < 0.8) {
      EXPECT_GT(frames[v].col(0).x(), 0.8) << v;
    }
    if (mesh.vertices[v].z() < -1.0) {
      EXPECT_EQ(both.turn[v], 0.0F);
    }
  }
  // Another direction of the scene's comb: strokes still lead where they went.
  fur.comb_turn_deg = 70.0;
  const Coat turned = painter.of(fur);
  expect_same(turned, coat_of(mesh, fur));
  const std::vector<SkinFrame> again = skin_frames(mesh, fur, turned);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if ((mesh.vertices[v] - on_ball(0.4)).norm() < 0.8) {
      EXPECT_GT(again[v].col(0).x(), 0.8) << v;
    }
  }
}

TEST(Coat, NeedsTextureCoordinates) {
  Fur fur;
  fur.density_map = halves("fur_halves.png");
  EXPECT_THAT(sentence_of([&] { coat_of(sphere_mesh(1.0, 8), fur); }),
              testing::HasSubstr("density_map needs a mesh with texture coordinates"));
}

TEST(Coat, GrowsHairWhereTheMapIsBright) {
  Scene scene = furry_scene();
  std::vector<std::string> warnings;
  World world(scene, warnings);
  WorldObject object = world.objects()[0].copy();
  object.rest = object.mesh = textured_ball();
  Fur fur = *scene.objects[0].fur;
  fur.rays = 16;
  fur.density_map = halves("fur_halves.png");
  Progress progress;
  FurTiles tiles;
  FurReport report;
  FurryObject furry(object, fur, tiles, report, progress);
  furry.set_light(world, {}, nullptr);
  double left = 0.0, right = 0.0;
  for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t) {
    double x = 0.0;
    for (const int v : object.mesh.triangles[t])
      x += object.mesh.vertices[static_cast<std::size_t>(v)].x();
    if (std::abs(x) < 6.0) continue;
    (x > 0.0 ? right : left) += furry.seen(t, 0.3, 0.3, 0, Vector3d::UnitZ()).density;
  }
  EXPECT_EQ(left, 0.0);
  EXPECT_GT(right, 1.0);
}

TEST(LiveFur, IsPlacedAndLitAsTheObject) {
  Scene scene = furry_scene();
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  Progress progress;
  FurTiles tiles;
  FurReport report;
  FurryObject furry(world.objects()[0], *scene.objects[0].fur, tiles, report, progress);
  const LightSources sources = make_light_sources(scene.lights);
  furry.set_light(world, sources, nullptr);
  // Corners blended as the card does, against Placement::at(). They differ where a corner's four
  // patches are not its triangle's.
  int corners = 0, alike = 0;
  const std::vector<float> geometry = fur_geometry(furry);
  for (std::size_t t = 0; t < world.objects()[0].mesh.triangles.size(); t += 7) {
    const Placement::Places places = furry.placement().at(t, 0.0, 0.0);
    const float* corner = geometry.data() + 3 * t * FurCorners::geometry_floats;
    double sum = 0.0, found = 0.0;
    constexpr int most = Placement::most_places;
    for (int k = 0; k < most; ++k) sum += std::pow(static_cast<double>(corner[9 + 3 * k + 2]), 4.0);
    for (int k = 0; k < most; ++k) {
      const double share = std::pow(static_cast<double>(corner[9 + 3 * k + 2]), 4.0) / sum;
      for (int i = 0; i < places.count; ++i) {
        const Placement::Place& place = places.place[static_cast<std::size_t>(i)];
        const double apart = place.tile.x() - static_cast<double>(corner[9 + 3 * k]);
        if (std::abs(apart - std::round(apart)) < 1e-4 && std::abs(share - place.weight) < 0.05) {
          found += share;
        }
      }
    }
    ++corners;
    if (found > 0.9) ++alike;
  }
  RecordProperty("corners unlike", corners - alike);
  EXPECT_GT(alike, 0.9 * corners) << alike << " of " << corners;
  // Light by modes against light by all coefficients, over the tile and by the hair.
  const FurVolume volume = make_fur_volume(furry.tile());
  EXPECT_LT(volume.lost, 0.05);
  const FurTile& tile = furry.tile();
  double difference = 0.0, all = 0.0;
  const Eigen::VectorXd lamp =
      forward::shells::harmonics(tile.transfer.bands, Vector3d(0.4, 0.1, 0.9).normalized());
  const Eigen::VectorXd reduced = volume.basis.transpose() * lamp;
  for (std::size_t i = 0; i < tile.texture.size(); ++i) {
    const double density = tile.texture.density[i];
    if (density <= 0.0) continue;
    const double exact = tile.transfer.lit(i, lamp)[0];
    const double seen = (static_cast<double>(volume.texels[0][4 * i + 3]) * reduced[0] +
                         static_cast<double>(volume.texels[1][4 * i + 3]) * reduced[1] +
                         static_cast<double>(volume.texels[2][4 * i]) * reduced[2] +
                         static_cast<double>(volume.texels[2][4 * i + 1]) * reduced[3] +
                         static_cast<double>(volume.texels[2][4 * i + 2]) * reduced[4]) /
                        density;
    difference += density * std::abs(seen - exact);
    all += density * std::abs(exact);
  }
  EXPECT_LT(difference, 0.2 * all);
  RecordProperty("modes' error", std::to_string(difference / all));
}

}  // namespace

}  // namespace kappamu::render
