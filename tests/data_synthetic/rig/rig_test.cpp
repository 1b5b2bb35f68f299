// The rig's geometry is one a calibration can live on, and its device shows what it should. Whole
// sessions are tested in simulate_test.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "data_synthetic/rig/simulated_rig.h"
#include "data_synthetic/rig/targets.h"
#include "tests/data_synthetic/tiny_options.h"

namespace kappamu::synthetic {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

TEST(Rig, HasABoardInEveryPartOfThePictureTiltedManyWays) {
  for (const std::string& name : sample_names()) {
    SimulationOptions options = name == "tiny" ? tiny_options() : SimulationOptions{};
    options.sample = name;
    const Rig rig = make_rig(options);
    Vector2d low(1e9, 1e9);
    Vector2d high(-1e9, -1e9);
    double steepest = 0.0;
    for (const Rigid& pose : rig.camera_from_board) {
      for (const Vector2d& corner :
           {Vector2d(0, 0), Vector2d(8, 0), Vector2d(0, 5), Vector2d(8, 5)}) {
        const Vector3d point(corner.x() * rig.board.square_mm, corner.y() * rig.board.square_mm, 0);
        const Vector2d pixel = rig.camera_lens.project(pose * point);
        EXPECT_TRUE(rig.camera_lens.contains(pixel, 5.0)) << name;
        low = low.cwiseMin(pixel);
        high = high.cwiseMax(pixel);
      }
      steepest = std::max(steepest, degrees(std::acos(pose.rotation(2, 2))));
    }
    // Corners reach into the outer eighth of the picture on all sides.
    EXPECT_LT(low.x(), rig.camera_lens.width / 8.0) << name;
    EXPECT_LT(low.y(), rig.camera_lens.height / 8.0) << name;
    EXPECT_GT(high.x(), rig.camera_lens.width * 7.0 / 8.0) << name;
    EXPECT_GT(high.y(), rig.camera_lens.height * 7.0 / 8.0) << name;
    EXPECT_GT(steepest, 25.0) << name;
  }
}

TEST(Rig, CanBeSetUpWithAnySeed) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SimulationOptions options = seed % 2 == 0 ? SimulationOptions{} : tiny_options();
    options.seed = seed;
    EXPECT_NO_THROW(make_rig(options)) << "seed " << seed;
  }
}

TEST(Rig, LooksAtTheSampleAsThePaperDoes) {
  for (const std::string& name : sample_names()) {
    SimulationOptions options = name == "tiny" ? tiny_options() : SimulationOptions{};
    options.sample = name;
    const Rig rig = make_rig(options);
    const GridShape& grid = rig.sample.grid;
    const Vector3d middle = 0.5 * grid.voxel_mm * Vector3d(grid.nx, grid.ny, 0.0);
    const auto angle_to_normal = [&](const std::string& station, double normal_z) {
      const Vector3d eye =
          (rig.world_from_sample.inverse() * rig.world_from_camera.at(station)).translation;
      return degrees(std::acos(normal_z * (eye - middle).normalized().z()));
    };
    EXPECT_GT(angle_to_normal(front_station, -1.0), 12.0) << name;
    EXPECT_LT(angle_to_normal(front_station, -1.0), 22.0) << name;
    EXPECT_LT(angle_to_normal(back_station, 1.0), 5.0) << name;
    // The whole seen face is in the picture, and fills a good part of it where nothing else must.
    const Rigid camera_from_sample =
        rig.world_from_camera.at(rig.pattern_station()).inverse() * rig.world_from_sample;
    const double z = is_plus(rig.sample.seen_face()) ? grid.nz * grid.voxel_mm : 0.0;
    double left = 1e9;
    double right = -1e9;
    for (const Vector3d& corner : {Vector3d(0, 0, z), Vector3d(grid.nx * grid.voxel_mm, 0, z),
                                   Vector3d(0, grid.ny * grid.voxel_mm, z),
                                   Vector3d(grid.nx * grid.voxel_mm, grid.ny * grid.voxel_mm, z)}) {
      const Vector2d pixel = rig.camera_lens.project(camera_from_sample * corner);
      EXPECT_TRUE(rig.camera_lens.contains(pixel, 5.0)) << name;
      left = std::min(left, pixel.x());
      right = std::max(right, pixel.x());
    }
    // More than two pixels per voxel, or calibration would limit the fit.
    EXPECT_GT((right - left) / grid.nx, 2.0) << name;
  }
}

TEST(Rig, MountsTheSampleALittleOffItsPlace) {
  const Rig rig = make_rig({});
  const Rig again = make_rig({});
  EXPECT_EQ(rig.world_from_sample.rotation, again.world_from_sample.rotation);
  const double turn = degrees(Eigen::AngleAxisd(rig.world_from_sample.rotation).angle());
  EXPECT_GT(turn, 0.1);
  EXPECT_LT(turn, 2.0);
}

Image<std::uint8_t> grey(const capture::Projector& projector, std::uint8_t value) {
  return Image<std::uint8_t>(projector.width, projector.height, 1, value);
}

double mean(const Image<std::uint16_t>& image) {
  double sum = 0.0;
  for (const std::uint16_t code : image.values()) sum += code;
  return sum / static_cast<double>(image.size());
}

TEST(SimulatedRig, ShowsEachSubjectInItsLight) {
  SimulationOptions options = tiny_options();
  options.noise_scale = 0.0;
  SimulatedRig rig(options, "reference");
  const Image<std::uint8_t> white = grey(rig.projector(), 255);
  Progress silent;
  rig.prepare({white}, silent);
  const double black = rig.rig().sensor.black_level * 4095.0;
  using capture::Lighting;
  const auto photograph = [&](capture::Subject subject, const std::string& station,
                              Lighting lighting, bool lit, double exposure_s) {
    rig.place({subject, station, lighting, 0, 8});
    if (lit) rig.show(white);
    return mean(rig.expose(exposure_s));
  };
  using capture::Subject;
  constexpr double one_code = 1.0;
  EXPECT_NEAR(photograph(Subject::lens_covered, "front", Lighting::room, true, 8.0), black,
              one_code);
  EXPECT_GT(photograph(Subject::board, "front", Lighting::room, false, 0.1), black + 200.0);
  EXPECT_NEAR(photograph(Subject::board, "front", Lighting::projector, false, 0.1), black,
              one_code);
  EXPECT_GT(photograph(Subject::plane, "front", Lighting::room, false, 0.1), black + 400.0);
  const double exposure = rig.white_exposure_s(0.8);
  const double target =
      photograph(Subject::white_target, "front", Lighting::projector, true, exposure);
  EXPECT_GT(target, black + 100.0);
  // The projector's black: 4500 times less light, so as many times the exposure.
  EXPECT_NEAR(
      photograph(Subject::white_target, "front", Lighting::projector, false, 4500.0 * exposure),
      target, one_code);
  EXPECT_GT(photograph(Subject::colour_chart, "front", Lighting::projector, true, exposure),
            black + 50.0);
  EXPECT_GT(photograph(Subject::sample, "front", Lighting::room, false, 0.1), black + 50.0);
  EXPECT_GT(photograph(Subject::sample, "back", Lighting::room, false, 0.1), black + 400.0);
  EXPECT_GT(photograph(Subject::sample, "back", Lighting::projector, true, 0.1), black + 400.0);
  EXPECT_THROW(rig.place({Subject::sample, "above", Lighting::projector, 0, 1}), InputError);
  EXPECT_THROW(rig.show(Image<std::uint8_t>(10, 10, 1)), InputError);
}

TEST(SimulatedRig, GainPutsTheBrightestLightAtTwoThirdsInTheShortestExposure) {
  SimulationOptions options = tiny_options();
  SimulatedRig rig(options, "reference");
  const Image<std::uint8_t> white = grey(rig.projector(), 255);
  Progress silent;
  rig.prepare({white}, silent);
  const Image<float> radiance = rig.sample_radiance(white);
  const float brightest = *std::max_element(radiance.values().begin(), radiance.values().end());
  // Pixels average a little over the brightest cell.
  constexpr double averaging = 0.02;
  EXPECT_NEAR(brightest * options.exposures_s.front(), 2.0 / 3.0, averaging);
}

TEST(SimulatedRig, LightsTheFaceThroughTheTrueLensOnly) {
  const SimulationOptions options = tiny_options();
  SimulatedRig rig(options, "reference");
  const FaceShape face = face_shape(rig.transport().block().shape, Face::z_minus);
  const std::vector<double> white = rig.lit_face_irradiance(grey(rig.projector(), 255));
  const std::vector<double> black = rig.lit_face_irradiance(grey(rig.projector(), 0));
  const std::size_t middle = static_cast<std::size_t>(face.nv / 2) * face.nu + face.nu / 2;
  // One at the centre (docs/conventions.md); a cell beside it differs by the falloff over a cell.
  EXPECT_NEAR(white[middle], 1.0, 2e-3);
  for (std::size_t i = 0; i < white.size(); ++i) {
    EXPECT_NEAR(black[i] * 4500.0, white[i], 1e-5);
    EXPECT_LE(white[i], 1.01);
  }
}

TEST(Transport, PatchesTileTheFaceAndAveragingUndoesSplitting) {
  const FaceShape face{13, 7};
  const std::vector<double> patches = patch_irradiance(face, 3);
  for (std::size_t i = 0; i < face.cells(); ++i) {
    double sum = 0.0;
    for (std::size_t m = 0; m < 9; ++m) sum += patches[m * face.cells() + i];
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
  const std::vector<double> back = average_cells(split_cells(patches, face, 3), {39, 21}, 3);
  for (std::size_t i = 0; i < patches.size(); ++i) EXPECT_NEAR(back[i], patches[i], 1e-12);
}

TEST(Transport, LightIsAdditive) {
  const SampleModel sample = make_sample("tiny", 1);
  Transport transport({.shape = sample.grid}, "reference");
  transport.set_medium(sample_medium(sample, sample.grid)[0]);
  const FaceShape face = face_shape(sample.grid, Face::z_minus);
  const std::vector<double> patches = patch_irradiance(face, 5);  // more than one batch
  const std::vector<double> parts = transport.exitance(patches, Face::z_plus);
  const std::vector<double> whole =
      transport.exitance(std::vector<double>(face.cells(), 1.0), Face::z_plus);
  for (std::size_t i = 0; i < face.cells(); ++i) {
    double sum = 0.0;
    for (std::size_t m = 0; m < 25; ++m) sum += parts[m * face.cells() + i];
    // 26 solves, each to a residual of 1e-6 of the light entering.
    constexpr double solves = 1e-4;
    EXPECT_NEAR(sum / whole[i], 1.0, solves);
  }
}

}  // namespace
}  // namespace kappamu::synthetic
