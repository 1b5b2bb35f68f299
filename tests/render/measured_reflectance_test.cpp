// The reflectance measured beside a volume, laid on blocks and on wrapped objects.
#include "render/scene/measured_reflectance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes.h"
#include "core/random.h"
#include "io/image/image_file.h"
#include "io/volume/volume_file.h"
#include "render/material/shell_field.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

constexpr GridShape shape{40, 32, 4, 0.5};

/// Of the voxel (x, y) of the face z-.
double reflectance_of(int x, int y) {
  return 0.1 + 0.05 * std::sin(0.4 * x) + 0.04 * std::cos(0.5 * y);
}

class MeasuredReflectanceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    io::VolumeSet set;
    set.channels = {"grey"};
    set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
    Image<float> image(shape.nx, shape.ny, 1);
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const double here = reflectance_of(x, y);
        image(x, shape.ny - 1 - y) = static_cast<float>(here);
        set.media[0].mu(x, y, 0) = here;  // the layer below the measured face
      }
    }
    io::write_volume_folder(folder_ / "volume", set);
    io::write_float_image(folder_ / "volume" / "reflectance_z-.exr", image);
    set_ = set;
  }
  VolumeMaterial material(VolumeMaterial::Placement placement) const {
    VolumeMaterial material;
    material.volume = folder_ / "volume";
    material.placement = placement;
    return material;
  }
  OwnFolder folder_;
  io::VolumeSet set_;
};

TEST_F(MeasuredReflectanceTest, LiesOnTheMeasuredFaceOfABlock) {
  const TriangleMesh block = box_mesh({20.0, 16.0, 2.0}, 8);
  VolumeMaterial turned = material(VolumeMaterial::Placement::stretch);
  turned.turn_deg = {0.0, 180.0, 0.0};
  for (const bool half_turn : {false, true}) {
    const auto found = measured_reflectance(
        half_turn ? turned : material(VolumeMaterial::Placement::stretch), block, block);
    const double side = half_turn ? -1.0 : 1.0;  // of x and z
    for (const auto& [x, y] : {std::array{3, 5}, std::array{30, 20}, std::array{39, 0}}) {
      const Vector3d at(side * ((x + 0.5) * shape.voxel_mm - 10.0),
                        (y + 0.5) * shape.voxel_mm - 8.0, -side);
      const Vector3d outward(0.0, 0.0, -side);
      EXPECT_NEAR(found->at({0, 0.0, 0.0, at, outward})[1], reflectance_of(x, y), 1e-6);
      EXPECT_EQ(found->at({0, 0.0, 0.0, at, -outward})[1], 0.0);
      EXPECT_EQ(found->at({0, 0.0, 0.0, at, Vector3d::UnitX()})[1], 0.0);
    }
  }
}

TEST_F(MeasuredReflectanceTest, RepeatsAndMirrorsWithItsVolume) {
  const TriangleMesh block = box_mesh({60.0, 16.0, 2.0}, 8);
  const Vector3d outward(0.0, 0.0, -1.0);
  const Vector3d beyond(10.0 + 2.5 * shape.voxel_mm, 0.5 * shape.voxel_mm - 8.0, -1.0);
  const auto at = [&](VolumeMaterial::Placement placement) {
    return measured_reflectance(material(placement), block, block)
        ->at({0, 0.0, 0.0, beyond, outward})[0];
  };
  EXPECT_NEAR(at(VolumeMaterial::Placement::repeat), reflectance_of(2, 0), 1e-6);
  EXPECT_NEAR(at(VolumeMaterial::Placement::mirror), reflectance_of(37, 0), 1e-6);
}

/// In every piece the reflectance lies over the voxels that it was measured on: μ of the outermost
/// layer is equal to it.
TEST_F(MeasuredReflectanceTest, LiesOverItsOwnVoxelsOfAShell) {
  const TriangleMesh ball = sphere_mesh(15.0, 32);
  VolumeMaterial shell = material(VolumeMaterial::Placement::shell);
  EXPECT_THAT(sentence_of([&] { measured_reflectance(shell, ball, ball); }, ""),
              ::testing::HasSubstr("write \"face\": \"z-\""));
  shell.shell.outside = Shell::Outside::z_minus;
  const auto found = measured_reflectance(shell, ball, ball);
  const ShellField field(set_, shell.shell, ball);
  const Surface surface = surface_of(ball);
  double difference = 0.0, spread = 0.0, count = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const Vector3d& point = surface.position[t];
    Place place;
    place.point = place.surface = point;
    place.normal = surface.normal[t];
    place.triangle = static_cast<int>(t);
    // Where one piece covers the place alone, nothing is mixed.
    const FacePlaces pieces = field.on_face(place);
    double sum = 0.0, most = 0.0;
    for (const FacePlace& one : pieces.all()) sum += one.weight, most = std::max(most, one.weight);
    if (most < 0.999 * sum) continue;
    const double here = found->at({t, 1.0 / 3.0, 1.0 / 3.0, point, surface.normal[t]})[0];
    difference += std::pow(here - field.at(place)[0].mu, 2);
    spread += std::pow(here - 0.1, 2);
    ++count;
  }
  ASSERT_GT(count, 100.0);
  // μ is that of the nearest voxel, the reflectance is interpolated.
  EXPECT_LT(std::sqrt(difference / count), 0.2 * std::sqrt(spread / count));
}

TEST_F(MeasuredReflectanceTest, WhatDoesNotFitIsRefused) {
  const TriangleMesh block = box_mesh({20.0, 16.0, 2.0}, 8);
  const VolumeMaterial measured = material(VolumeMaterial::Placement::stretch);
  EXPECT_THAT(sentence_of([&] { measured_reflectance(HomogeneousMaterial{}, block, block); }, ""),
              ::testing::HasSubstr("not a volume"));
  io::write_float_image(folder_ / "volume" / "reflectance_z-.exr", Image<float>(7, 5, 1));
  EXPECT_THAT(sentence_of([&] { measured_reflectance(measured, block, block); }, ""),
              ::testing::HasSubstr("7 x 5 pixels"));
  std::filesystem::remove(folder_ / "volume" / "reflectance_z-.exr");
  EXPECT_THAT(sentence_of([&] { measured_reflectance(measured, block, block); }, ""),
              ::testing::HasSubstr("no reflectance_z-.exr"));
}

}  // namespace
}  // namespace kappamu::render
