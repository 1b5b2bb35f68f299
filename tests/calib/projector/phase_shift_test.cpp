// Phase-shifted light: the map of a simulated plane against the rig's truth, by several periods and
// by one beside a Gray code; ambiguous and dark pixels are not legible; and maps of other programs.
#include "calib/projector/phase_shift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <limits>

#include "calib/projector/correspondences.h"
#include "calib/projector/gray_code.h"
#include "capture/rig/shoot.h"
#include "io/npy.h"
#include "tests/calib/projector/coded_plane.h"
#include "tests/data_synthetic/tiny_options.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::held;
using testing::Misses;
using testing::misses;
using testing::photographs;
using Along = capture::PhaseShift::Along;

PhaseFrames seen(const synthetic::Rig& rig, const Rigid& plane, const capture::PhaseShift& set,
                 int steps) {
  return {set.along, set.period_px, static_cast<std::size_t>(steps),
          held(photographs(rig, plane,
                           capture::make_phase_shift_images(rig.projector_size, set, steps), 7))};
}

class PhaseShift : public ::testing::TestWithParam<int> {
 protected:
  const synthetic::Rig rig = synthetic::make_rig(synthetic::tiny_options());
  const Rigid& plane = rig.world_from_plane[3];
  const capture::ProjectedBoard lattice = map_lattice(rig.projector_size);
};

INSTANTIATE_TEST_SUITE_P(Steps, PhaseShift, ::testing::Values(3, 4, 6));

TEST_P(PhaseShift, PointsLieWhereTheProjectorThrowsThem) {
  std::vector<PhaseFrames> sets;
  for (const capture::PhaseShift& set : capture::usual_phase_shift(rig.projector_size)) {
    sets.push_back(seen(rig, plane, set, GetParam()));
  }
  const ProjectorMap map = decode_phase_shift(sets, rig.projector_size);
  const Misses found = misses(rig, plane, lattice, mapped_corners(map, lattice, "phase"));
  std::printf("%d steps: %zu points, RMS %.4f px, largest %.4f px\n", GetParam(), found.points,
              found.rms_px, found.largest_px);
  EXPECT_GT(found.points, 300U);
  EXPECT_LT(found.rms_px, 0.04);
  EXPECT_LT(found.largest_px, 0.15);
}

TEST_F(PhaseShift, OnePeriodBesideAGrayCodeIsEnough) {
  const ProjectorMap coarse = decode_gray_code(
      held(photographs(rig, plane, capture::make_gray_code_images(rig.projector_size), 3)),
      rig.projector_size);
  const std::vector<PhaseFrames> sets{seen(rig, plane, {Along::columns, 20.0, {}}, 4),
                                      seen(rig, plane, {Along::rows, 20.0, {}}, 4)};
  const ProjectorMap map = decode_phase_shift(sets, rig.projector_size, coarse);
  const Misses found = misses(rig, plane, lattice, mapped_corners(map, lattice, "both"));
  EXPECT_GT(found.points, 300U);
  EXPECT_LT(found.rms_px, 0.04);
}

TEST(PhaseShiftPixels, DarkOnesAndOnesBetweenTwoPeriodsAreNotLegible) {
  const capture::Projector projector{64, 64};
  // Three pixels: bright; dark; bright, but the long period is wrong by half the short one.
  const double u = 21.0;
  const auto frames = [&](double period, double wrong) {
    std::vector<Image<float>> shown;
    for (int n = 0; n < 4; ++n) {
      Image<float> image(3, 1, 1);
      const auto light = [&](double at) {
        return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * (at / period - n / 4.0));
      };
      image(0, 0) = static_cast<float>(light(u));
      image(1, 0) = 0.001F * static_cast<float>(light(u));
      image(2, 0) = static_cast<float>(light(u + wrong));
      shown.push_back(image);
    }
    return held(shown);
  };
  std::vector<PhaseFrames> sets;
  for (const Along along : {Along::columns, Along::rows}) {
    sets.push_back({along, 64.0, 4, frames(64.0, 4.0)});
    sets.push_back({along, 8.0, 4, frames(8.0, 0.0)});
  }
  const ProjectorMap map = decode_phase_shift(sets, projector);
  EXPECT_NEAR(map.pixel(0, 0, 0), u, 1e-3);
  EXPECT_NEAR(map.pixel(0, 0, 1), u, 1e-3);
  EXPECT_NEAR(map.quality(0, 0), 1.0, 1e-5);
  EXPECT_EQ(map.quality(1, 0), 0.0F);
  EXPECT_EQ(map.quality(2, 0), 0.0F);
}

class Correspondences : public ::testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(csv_) << text; }
  ProjectorMap read(const fs::path& file) const {
    return read_correspondences(file, camera_, {640, 480});
  }
  const OwnFolder folder_;
  const fs::path csv_ = folder_ / "map.csv";
  const fs::path npy_ = folder_ / "map.npy";
  const capture::Camera camera_ = [] {
    capture::Camera camera;
    camera.width = 4;
    camera.height = 3;
    return camera;
  }();
};

TEST_F(Correspondences, CsvAndNpyGiveOneMap) {
  write("x,y,column,row\n1,2,100.25,50.5\n3,0,7,8\n");
  std::vector<float> values(4 * 3 * 2, std::numeric_limits<float>::quiet_NaN());
  const auto set = [&](int x, int y, float column, float row) {
    values[2 * static_cast<std::size_t>(4 * y + x)] = column;
    values[2 * static_cast<std::size_t>(4 * y + x) + 1] = row;
  };
  set(1, 2, 100.25F, 50.5F);
  set(3, 0, 7.0F, 8.0F);
  io::write_npy(npy_, {3, 4, 2}, std::span<const float>(values));
  const ProjectorMap a = read(csv_), b = read(npy_);
  EXPECT_EQ(a.pixel.values(), b.pixel.values());
  EXPECT_EQ(a.quality.values(), b.quality.values());
  EXPECT_EQ(a.pixel(1, 2, 0), 100.25F);
  EXPECT_DOUBLE_EQ(a.legible_share(), 2.0 / 12.0);
}

TEST_F(Correspondences, WhatCannotBeUsedIsNamed) {
  const auto sentence = [&](const std::string& text) {
    write(text);
    return sentence_of([&] { read(csv_); });
  };
  EXPECT_THAT(sentence("u,v\n"), HasSubstr("names no column 'x'"));
  EXPECT_THAT(sentence("x,y,column,row\n"), HasSubstr("holds no correspondence"));
  for (const char* line : {"9,0,1,1", "0,0,640,1", "0.5,0,1,1", "0,0,1", "a,b,c,d", "0,0,nan,1"}) {
    EXPECT_THAT(sentence(std::string("x,y,column,row\n") + line + "\n"), HasSubstr("line 2"))
        << line;
  }
  EXPECT_THAT(sentence_of([&] { read("map.txt"); }), HasSubstr(".csv or a .npy"));
}

}  // namespace
}  // namespace kappamu::calib
