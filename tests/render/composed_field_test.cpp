// Patterns, layers and parts as materials.
#include "render/scene/composed_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes.h"
#include "core/process_memory.h"
#include "core/random.h"
#include "io/volume/volume_file.h"
#include "render/material/baked_field.h"
#include "render/material/normal_scores.h"
#include "render/material/pattern.h"
#include "render/material/published_materials.h"
#include "render/material/surface_places.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

Vector3d random_point(std::uint64_t i, double size) {
  return size * Vector3d(uniform(key_of({i, 1})) - 0.5, uniform(key_of({i, 2})) - 0.5,
                         uniform(key_of({i, 3})) - 0.5);
}

TEST(GradientNoise, IsZeroOnItsLatticeSmoothAndWithoutMean) {
  double sum = 0.0, squares = 0.0;
  constexpr int count = 20000;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Vector3d point = random_point(i, 200.0);
    EXPECT_NEAR(gradient_noise(point.array().floor(), 3), 0.0, 1e-12);
    const double here = gradient_noise(point, 3);
    // Its slope is at most that of its gradients, of length √2, and of its blending, 15/8 per axis.
    EXPECT_NEAR(gradient_noise(point + Vector3d(1e-4, 0, 0), 3), here, 6e-4);
    sum += here;
    squares += here * here;
  }
  EXPECT_NEAR(sum / count, 0.0, 5.0 * std::sqrt(squares) / count);
  EXPECT_GT(squares / count, 0.02);
}

/// [T] 4.3: a mixture of marble whose densities are 1:10.
TEST(MixedField, StaysBetweenItsMaterialsAndMixesDensities) {
  HomogeneousMaterial thin = published_material("marble"), dense = thin;
  dense.kappa_mm /= 10.0;
  dense.mu_per_mm *= 10.0;
  const TriangleMesh ball = sphere_mesh(10.0, 8);
  for (const Pattern::Kind kind :
       {Pattern::Kind::noise, Pattern::Kind::marble, Pattern::Kind::veins}) {
    auto mix = std::make_shared<ComposedMaterial>();
    mix->materials = {thin, dense};
    Pattern pattern;
    pattern.kind = kind;
    pattern.size_mm = 4.0;
    mix->by = pattern;
    const NamedField made = make_field(Material(mix), ball);
    EXPECT_EQ(made.eta, thin.eta);
    double least = 100.0, most = 0.0;
    for (std::uint64_t i = 0; i < 5000; ++i) {
      Place place;
      place.point = random_point(i, 18.0);
      const ColourCoefficients here = made.field->at(place);
      const double density = here[0].mu / thin.mu_per_mm[0];
      least = std::min(least, density);
      most = std::max(most, density);
      for (int c = 0; c < 3; ++c) {
        const auto& channel = here[static_cast<std::size_t>(c)];
        EXPECT_NEAR(channel.mu / thin.mu_per_mm[c], density, 1e-9);
        EXPECT_NEAR(thin.kappa_mm[c] / channel.kappa, density, 1e-9);
      }
    }
    EXPECT_GE(least, 1.0 - 1e-12);
    EXPECT_LE(most, 10.0 + 1e-12);
    EXPECT_LT(least, 2.0);
    EXPECT_GT(most, 9.0);
  }
}

TEST(LayeredField, ChangesAtItsDepths) {
  auto skin = std::make_shared<ComposedMaterial>();
  for (const char* name : {"skin1", "skin2", "ketchup"})
    skin->materials.emplace_back(published_material(name));
  skin->by = ComposedMaterial::Layers{{0.5, 1.5}};
  const TriangleMesh ball = sphere_mesh(10.0, 32);
  const NamedField made = make_field(Material(skin), ball);
  const SurfacePlaces places(ball);
  double outside = 0.0;
  const auto mu = [&](double depth) {
    return made.field->at(places.at((9.97 - depth) * Vector3d(0.0, 0.6, 0.8), 0, outside))[1].mu;
  };
  EXPECT_EQ(mu(0.3), published_material("skin1").mu_per_mm[1]);
  EXPECT_EQ(mu(0.7), published_material("skin2").mu_per_mm[1]);
  EXPECT_EQ(mu(1.8), published_material("skin2").mu_per_mm[1]);
  EXPECT_EQ(mu(2.2), published_material("ketchup").mu_per_mm[1]);
}

/// The share of a ball's voxels that a smaller ball inside takes is that of their volumes.
TEST(PartedField, PutsBodiesInside) {
  SceneObject part;
  part.name = "stone";
  part.shape = std::string("sphere");
  part.size_mm = 6.0;
  part.position_mm = {2.0, -1.0, 0.5};
  part.material = published_material("ketchup");
  auto whole = std::make_shared<ComposedMaterial>();
  whole->materials.emplace_back(published_material("marble"));
  whole->by = ComposedMaterial::Parts{{part}};
  const TriangleMesh ball = sphere_mesh(8.0, 24);
  std::vector<std::string> warnings;
  const Baked voxels = baked(*make_field(Material(whole), ball).field, ball, warnings);
  const GridShape& s = voxels.set.shape();
  const double stone = published_material("ketchup").mu_per_mm[1];
  double volume = 0.0;
  Vector3d centre = Vector3d::Zero();
  for (int z = 0; z < s.nz; ++z) {
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) {
        if (voxels.set.media[1].mu(x, y, z) != stone) continue;
        volume += std::pow(s.voxel_mm, 3);
        centre += voxels.corner_mm + s.voxel_mm * Vector3d(x + 0.5, y + 0.5, z + 0.5);
      }
    }
  }
  const double expected = 4.0 / 3.0 * M_PI * 27.0;
  EXPECT_NEAR(volume / expected, 1.0, 0.03);
  EXPECT_LT((centre * std::pow(s.voxel_mm, 3) / volume - part.position_mm).norm(), 0.1);
}

/// A part that no voxel would show.
TEST(PartedField, RefusesAPartBesideTheObject) {
  SceneObject part;
  part.shape = std::string("sphere");
  part.size_mm = 6.0;
  part.position_mm = {0.0, 40.0, 0.0};
  part.material = published_material("ketchup");
  auto whole = std::make_shared<ComposedMaterial>();
  whole->materials.emplace_back(published_material("marble"));
  whole->by = ComposedMaterial::Parts{{part}};
  const TriangleMesh ball = sphere_mesh(8.0, 24);
  EXPECT_THAT(sentence_of([&] { make_field(Material(whole), ball); }, ""),
              ::testing::HasSubstr("parts[0] lies outside the object"));
}

/// Wrapping states the memory that it needs before it begins.
TEST(ShellField, StatesItsMemoryFirst) {
  struct Listener : Progress {
    void update(const std::string& stage, double, const std::string& detail) override {
      if (stage == "wrap ball") said = detail;
    }
    std::string said;
  } listener;
  const OwnFolder folder;
  constexpr GridShape shape{12, 12, 6, 0.5};
  io::VolumeSet block;
  block.channels = {"grey"};
  block.media = {{Volume<double>(shape, 0.3), Volume<double>(shape, 0.02)}};
  io::write_volume_folder(folder / "block", block);
  VolumeMaterial material{folder / "block"};
  material.placement = VolumeMaterial::Placement::shell;
  Scene scene;
  scene.objects.emplace_back();
  scene.objects[0].name = "ball";
  expect_wrap_memory(scene, listener);
  EXPECT_EQ(listener.said, "");
  scene.objects[0].material = material;
  expect_wrap_memory(scene, listener);
  const double bytes = NormalScores::bytes(block) + 2.0 * bytes_per_baked_voxel * most_baked_voxels;
  EXPECT_EQ(listener.said, "up to " + gigabytes(bytes) + " of memory");
}

/// Channels that are the same everywhere are one, which is solved once.
TEST(Baked, SharesEqualChannels) {
  auto mix = std::make_shared<ComposedMaterial>();
  mix->materials = {homogeneous_material(Colour::Constant(1.0), Colour::Constant(0.01)),
                    homogeneous_material(Colour::Constant(3.0), Colour::Constant(0.02))};
  mix->by = Pattern{};
  const TriangleMesh ball = sphere_mesh(2.0, 8);
  std::vector<std::string> warnings;
  EXPECT_EQ(baked(*make_field(Material(mix), ball).field, ball, warnings).set.channels,
            std::vector<std::string>{"grey"});
}

}  // namespace
}  // namespace kappamu::render
