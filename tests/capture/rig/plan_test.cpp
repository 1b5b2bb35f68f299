// A plan lists what shoot_session() will photograph; a replayed folder is shot anew to the same.
#include "capture/rig/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/session/frames.h"
#include "io/image/image_file.h"
#include "tests/capture/rig/replay.h"
#include "tests/capture/session_files.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

PlanRequest small_request() {
  PlanRequest request;
  request.sample.name = "block";
  request.sample.grid = {20, 16, 8};
  request.sample.voxel_mm = 0.5;
  request.camera = {40, 30, 12, Encoding::linear, {}, {}, {}};
  request.projector = {200, 150};
  request.projector_px_per_mm = 8.0;
  request.longest_s = 1.0;
  request.light = {LightShape::patches, 2};
  request.validate_patches = 1;
  request.boards = 3;
  request.planes = 2;
  return request;
}

TEST(ExposureTimes, AreRisingMultiplesOfThePeriodFromAThirtiethUp) {
  for (const double period : {1.0 / 60.0, 1.0 / 50.0, 1.0 / 120.0, 0.025}) {
    for (const int count : {1, 2, 5, 9}) {
      const std::vector<double> times = exposure_times(period, 4.0, count);
      for (std::size_t i = 0; i < times.size(); ++i) {
        const double periods = times[i] / period;
        EXPECT_NEAR(periods, std::round(periods), 1e-9);
        EXPECT_GE(times[i], 1.0 / 30.0 - 1e-12);
        EXPECT_LE(times[i], 4.0 + 1e-9);
        if (i > 0) {
          EXPECT_GT(times[i], times[i - 1]);
        }
      }
      EXPECT_EQ(times.size(), static_cast<std::size_t>(count));
    }
  }
  EXPECT_NEAR(exposure_times(1.0 / 60.0, 4.0, 5).back(), 4.0, 1e-9);
  // Only 2, 3 and 4 periods lie between 1/30 and 1/15 s.
  EXPECT_EQ(exposure_times(1.0 / 60.0, 1.0 / 15.0, 9).size(), 3U);
  EXPECT_THAT(sentence_of([] { exposure_times(1.0 / 60.0, 0.02, 3); }),
              HasSubstr("longest exposure of 0.02 s is below 0.0333333 s"));
}

TEST(PlannedLight, IsEightBarsEitherWayUnlessPatchesAreChosen) {
  const auto lit_share = [](const FitLight& light) {
    PlanRequest request = small_request();
    request.light = light;
    const Plan plan = make_plan(request, "nowhere");
    EXPECT_EQ(std::count_if(plan.capture.patterns.begin(), plan.capture.patterns.end(),
                            [](const PlannedPattern& p) { return p.role == PatternRole::fit; }),
              16);
    const auto& image = plan.capture.patterns.front().image.values();
    return static_cast<double>(std::count(image.begin(), image.end(), 255)) /
           static_cast<double>(image.size());
  };
  // An outer bar of eight crosses the whole face.
  EXPECT_GT(lit_share(PlanRequest{}.light), 1.2 * lit_share({LightShape::patches, 4}));
}

class PlanUnder : public testing::TestWithParam<PlaneLight> {
 protected:
  Plan written() {
    PlanRequest request = small_request();
    request.plane_light = GetParam();
    if (GetParam() == PlaneLight::both) {
      request.projector_levels = 2;
      request.ambient = true;
    }
    Plan plan = make_plan(request, folder.path());
    write_plan(plan);
    return plan;
  }
  bool chessboards() const {
    return GetParam() == PlaneLight::chessboard || GetParam() == PlaneLight::both;
  }
  bool codes() const { return gray_codes(GetParam()); }
  const OwnFolder folder;
};
INSTANTIATE_TEST_SUITE_P(Light, PlanUnder,
                         testing::Values(PlaneLight::chessboard, PlaneLight::gray_code,
                                         PlaneLight::both, PlaneLight::phase_shift),
                         [](const auto& light) {
                           std::string name = name_of(plane_light_names, light.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(PlanUnder, ListsEveryPhotographOfItsSessionOnce) {
  const Plan plan = written();
  const Session session = read_session(folder.path());
  EXPECT_EQ(session.patterns.size(), 5U);
  std::vector<std::string> listed;
  for (const Shot& shot : plan.shots) listed.push_back(shot.file);
  std::vector<std::string> needed;
  const auto need = [&](const std::vector<Frame>& frames) {
    for (const Frame& frame : frames) needed.push_back(frame.file);
  };
  for (const Pattern& pattern : session.patterns) need(pattern.frames);
  const Calibration& shots = session.calibration;
  need(shots.dark);
  need(shots.camera_boards);
  for (const ProjectorPlane& plane : shots.projector_planes) {
    need({plane.board});
    EXPECT_EQ(plane.projected.has_value(), chessboards());
    if (plane.projected) need({*plane.projected});
    EXPECT_EQ(plane.gray_code.size(), codes() ? 34U : 0U);  // 8 bits of columns, 8 of rows
    need(plane.gray_code);
    EXPECT_EQ(plane.phase_shift.size(), GetParam() == PlaneLight::phase_shift ? 6U : 0U);
    for (const PhaseShift& set : plane.phase_shift) need(set.frames);
  }
  for (const SampleView& view : shots.sample_views) need({view.frame});
  need(shots.white_target->frames);
  need(shots.white_target->black_frames);
  need(shots.white_target->off_frames);
  EXPECT_EQ(shots.white_target->levels.size(), GetParam() == PlaneLight::both ? 2U : 0U);
  for (const ProjectorLevel& level : shots.white_target->levels) need(level.frames);
  EXPECT_EQ(shots.ambient.size(), GetParam() == PlaneLight::both ? 2U : 0U);
  for (const Stack& frames : shots.ambient) need(frames);
  need(shots.colour_chart->frames);
  EXPECT_THAT(listed, testing::UnorderedElementsAreArray(needed));
  // Every image that the list tells the projector to show is there.
  for (const Shot& shot : plan.shots) {
    if (shot.show.find(".png") == std::string::npos) continue;
    EXPECT_TRUE(fs::exists(folder.path() / shot.show)) << shot.show;
  }
  for (const char* file : {"shots.csv", "shots.txt"}) {
    EXPECT_TRUE(fs::exists(folder.path() / file)) << file;
  }
  EXPECT_EQ(fs::exists(folder.path() / "calibration/projected_board.png"), chessboards());
  const auto json = nlohmann::json::parse(read_text(folder.path() / "shots.json"));
  EXPECT_EQ(json.at("shots").size(), listed.size());
  EXPECT_GT(plan.working_s, plan.exposing_s);
  EXPECT_EQ(plan.disk_bytes, 6.0 * 40 * 30 * static_cast<double>(listed.size()));
}

TEST(Plan, AContradictionIsToldWithTheNumbers) {
  PlanRequest request = small_request();
  request.projector_px_per_mm = 30.0;
  EXPECT_THAT(sentence_of([&] { make_plan(request, "plan"); }),
              HasSubstr("lit face of 10 x 8 mm is 300 x 240 projector pixels"));
  request = small_request();
  request.projector_px_per_mm = 1.5;
  EXPECT_THAT(sentence_of([&] { make_plan(request, "plan"); }),
              HasSubstr("voxel of 0.5 mm is smaller than a projector pixel"));
}

// The folder is filled as the list says (each photograph its own grey), then replayed as a device.
TEST_P(PlanUnder, ShootingAReplayedFolderGivesTheSameFolder) {
  const Plan plan = written();
  std::uint16_t code = 1;
  for (const Shot& shot : plan.shots) {
    io::write_code_image(folder.path() / shot.file, Image<std::uint16_t>(40, 30, 3, ++code), 12);
  }
  FolderReplay device(folder.path());
  const OwnFolder again;
  Progress silent;
  const Session session = shoot_session(device, plan.capture, again.path(), silent);
  EXPECT_EQ(read_text(again.path() / "session.json"), read_text(folder.path() / "session.json"));
  for (const Shot& shot : plan.shots) {
    EXPECT_EQ(load_frame(session, {shot.file, 1.0}).values(),
              load_frame(plan.session, {shot.file, 1.0}).values())
        << shot.file;
  }
}

TEST(FolderReplay, AnExposureThatWasNotTakenIsRefused) {
  const OwnFolder folder;
  const Plan plan = make_plan(small_request(), folder.path());
  write_plan(plan);
  FolderReplay device(folder.path());
  device.place({Subject::white_target, "front", Lighting::projector, 0, 1});
  EXPECT_THAT(sentence_of([&] { device.expose(0.7); }),
              HasSubstr("have no exposure of 0.7 s; replay with the plan"));
}

}  // namespace
}  // namespace kappamu::capture
