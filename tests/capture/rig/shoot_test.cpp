// Shooting a plan: which scenes the driver is asked for, what lies in the folder, and that what was
// written is read back. The full simulator is tested in data_synthetic.
#include "capture/rig/shoot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "capture/radiance/merge.h"
#include "capture/response/radiometry.h"
#include "capture/session/frames.h"
#include "io/image/image_file.h"
#include "tests/capture/session_files.h"
#include "tests/capture/simulated_camera.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

// A rig whose every picture is a smooth ramp, scaled by what the projector shows.
class RampRig final : public RigDevice {
 public:
  Camera camera() const override {
    Camera camera;
    camera.width = 96;
    camera.height = 64;
    camera.bit_depth = 12;
    camera.encoding = Encoding::response;
    return camera;
  }
  Projector projector() const override { return {64, 48}; }
  void place(const Scene& scene) override {
    ++placed;
    scene_ = scene;
    level_ = scene.lighting == Lighting::room ? 1.0 : 0.0;
  }
  void show(const Image<std::uint8_t>& image) override {
    double sum = 0.0;
    for (const std::uint8_t value : image.values()) sum += value;
    level_ = sum / 255.0 / static_cast<double>(image.size());
  }
  Image<std::uint16_t> expose(double exposure_s) override {
    ++exposed;
    const SimulatedCamera sensor{12, 40.0, 8000.0, 2.0, srgb_curve};
    Image<float> radiance = smooth_scene(96, 64, 3, 0.01, 12.0);
    const double scale = scene_.subject == Subject::lens_covered ? 0.0 : level_;
    for (float& value : radiance.values()) value *= static_cast<float>(scale);
    return shoot_stack(sensor, radiance, {exposure_s}, static_cast<unsigned>(exposed))[0].pixels;
  }

  int placed = 0;
  int exposed = 0;

 private:
  Scene scene_;
  double level_ = 0.0;
};

CapturePlan small_plan() {
  CapturePlan plan;
  plan.sample = {"ramp", {8, 6, 4}, 0.5, 1.3, Sides::open, Face::z_minus, Face::z_plus};
  plan.patterns = make_patch_patterns({64, 48}, {{{10, 5}, {50, 6}, {52, 40}, {9, 41}}}, 2, 0.0,
                                      PatternRole::fit, "fit_");
  plan.exposures_s = seven_exposures();
  plan.board = {9, 6, 4.0};
  plan.camera_board_views = 3;
  plan.projected_board = {5, 4, 6.0, {12.0, 10.0}};
  plan.projector_plane_poses = 2;
  plan.white_reflectance = 0.99;
  return plan;
}

TEST(Shoot, WritesASessionThatReadsBackAndWhoseFramesAllLoad) {
  const OwnFolder folder;
  RampRig rig;
  Progress silent;
  const Session shot = shoot_session(rig, small_plan(), folder.path(), silent);
  const Session session = read_session(folder.path());
  EXPECT_EQ(session.patterns.size(), 4U);
  EXPECT_EQ(session.patterns[3].id, "fit_03");
  EXPECT_EQ(session.calibration.camera_boards.size(), 3U);
  EXPECT_EQ(session.calibration.projector_planes.size(), 2U);
  EXPECT_EQ(session.calibration.sample_views.size(), 2U);
  EXPECT_EQ(session.calibration.dark.size(), 4U);
  EXPECT_EQ(session.calibration.white_target->black_frames.size(), 7U);
  for (const Pattern& pattern : session.patterns) {
    for (const Frame& frame : pattern.frames) EXPECT_EQ(load_frame(session, frame).channels(), 3);
    EXPECT_EQ(io::read_code_image(folder.path() / pattern.image).width(), 64);
  }
  // Metered frames hardly saturate, and are not left dark either: the ramp spans three decades.
  const Image<std::uint16_t> board = load_frame(session, session.calibration.camera_boards[0]);
  const auto bright = std::count_if(board.values().begin(), board.values().end(),
                                    [](std::uint16_t code) { return code > 2000; });
  EXPECT_GT(bright, 100);
}

// The loop of the real pipeline on the folder alone: radiometry told by the frames themselves.
TEST(Shoot, TheFolderAloneTellsResponseAndNoise) {
  const OwnFolder folder;
  RampRig rig;
  Progress silent;
  shoot_session(rig, small_plan(), folder.path(), silent);
  const Session session = read_session(folder.path());
  const Radiometry radiometry = find_radiometry(session, silent);
  ASSERT_EQ(radiometry.response.linear.size(), 3U);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(radiometry.black_level[c], 40.0, 0.5);
    EXPECT_TRUE(radiometry.noise[c].estimated);
    EXPECT_NEAR(radiometry.noise[c].electrons_full_scale / 8000.0, 1.0, 0.25) << c;
    std::printf("channel %zu: %.0f electrons at full scale (8000), read noise %.2f (2)\n", c,
                radiometry.noise[c].electrons_full_scale, radiometry.noise[c].read_noise_electrons);
  }
  const HdrImage merged =
      merge_stack(session, session.calibration.white_target->frames, "white", radiometry);
  const Image<float> truth = smooth_scene(96, 64, 3, 0.01, 12.0);
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (merged.flags.values()[i] != pixel_ok) continue;
    errors.push_back(std::abs(merged.radiance.values()[i] / truth.values()[i] - 1.0));
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2),
                   errors.end());
  const double median_error = errors[errors.size() / 2];
  std::printf("median relative HDR error %.2f %%\n", 100.0 * median_error);
  EXPECT_GT(errors.size(), truth.size() / 2);
  // Shot noise of 8000 electrons alone is 1 % of a pixel's radiance.
  EXPECT_LT(median_error, 0.02);
}

TEST(Shoot, AContradictoryPlanIsRefusedBeforeTheFirstExposure) {
  const OwnFolder folder;
  Progress silent;
  const auto refused = [&](const std::function<void(CapturePlan&)>& edit) {
    RampRig rig;
    CapturePlan plan = small_plan();
    edit(plan);
    const std::string sentence =
        sentence_of([&] { shoot_session(rig, plan, folder.path(), silent); });
    EXPECT_EQ(rig.exposed, 0) << sentence;
    EXPECT_EQ(rig.placed, 0) << sentence;
    return sentence;
  };
  EXPECT_THAT(refused([](CapturePlan& plan) { plan.exposures_s.clear(); }),
              testing::HasSubstr("exposures_s is empty"));
  EXPECT_THAT(refused([](CapturePlan& plan) { plan.exposures_s[1] = 0.0; }),
              testing::HasSubstr("must be a positive number"));
  EXPECT_THAT(refused([](CapturePlan& plan) { plan.pattern_station = "front"; }),
              testing::HasSubstr("two names"));
  EXPECT_THAT(refused([](CapturePlan& plan) { plan.patterns[1].id = "fit_00"; }),
              testing::HasSubstr("own id"));
  EXPECT_THAT(
      refused([](CapturePlan& plan) { plan.patterns[1].image = Image<std::uint8_t>(8, 8, 1); }),
      testing::HasSubstr("fit_01 is 8 x 8 in 1 channels; make it grey"));
  EXPECT_THAT(refused([](CapturePlan& plan) { plan.projected_board.square_px = 30.0; }),
              testing::HasSubstr("projector's 64 pixels"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "session.json"));
}

TEST(PatchPatterns, TileTheQuadOnceEach) {
  const Projector projector{101, 83};
  const ProjectorQuad quad{{{12.3, 7.7}, {88.1, 10.2}, {92.6, 71.4}, {8.9, 75.5}}};
  const auto patches = make_patch_patterns(projector, quad, 3, 0.0, PatternRole::validate, "v_");
  ASSERT_EQ(patches.size(), 9U);
  EXPECT_EQ(patches[8].id, "v_08");
  const auto whole = make_patch_patterns(projector, quad, 1, 0.0, PatternRole::validate, "w_");
  for (std::size_t i = 0; i < whole[0].image.size(); ++i) {
    int lit = 0;
    for (const PlannedPattern& patch : patches) lit += patch.image.values()[i] == 255 ? 1 : 0;
    ASSERT_EQ(lit, whole[0].image.values()[i] == 255 ? 1 : 0) << i;
  }
  // First corner (u, v) = (0, 0), u along to the second: pixels just inside the quad's corners.
  EXPECT_EQ(patches[0].image(14, 10), 255);
  EXPECT_EQ(patches[2].image(86, 12), 255);
  EXPECT_EQ(patches[8].image(90, 69), 255);
  EXPECT_EQ(patches[6].image(11, 73), 255);
}

// With an overhang the same cells grow outwards only: every pixel inside keeps its patch, and each
// pixel of a frame around the quad is lit by exactly one outer patch.
TEST(PatchPatterns, OverhangGrowsTheOuterPatchesOutwards) {
  const Projector projector{100, 80};
  // Edges between pixels, so that rounding does not decide.
  const ProjectorQuad quad{{{19.5, 19.5}, {79.5, 19.5}, {79.5, 59.5}, {19.5, 59.5}}};
  const auto exact = make_patch_patterns(projector, quad, 3, 0.0, PatternRole::fit, "e_");
  const auto wide = make_patch_patterns(projector, quad, 3, 0.11, PatternRole::fit, "w_");
  for (int y = 0; y < projector.height; ++y) {
    for (int x = 0; x < projector.width; ++x) {
      const bool inside = x >= 20 && x < 80 && y >= 20 && y < 60;
      const bool framed = x >= 13 && x <= 86 && y >= 16 && y <= 63;
      int lit = 0;
      for (std::size_t m = 0; m < wide.size(); ++m) {
        lit += wide[m].image(x, y) == 255 ? 1 : 0;
        if (inside) {
          ASSERT_EQ(wide[m].image(x, y), exact[m].image(x, y)) << x << ' ' << y;
        }
      }
      ASSERT_EQ(lit, framed ? 1 : 0) << x << ' ' << y;
    }
  }
}

// Both sets of bars light every pixel of the quad once, and bars along u know nothing of v.
TEST(FitPatterns, BarsCrossTheFaceAlongEitherAxis) {
  const Projector projector{101, 83};
  const ProjectorQuad quad{{{12.3, 7.7}, {88.1, 10.2}, {92.6, 71.4}, {8.9, 75.5}}};
  const auto bars = make_fit_patterns(projector, quad, {LightShape::bars, 3}, 0.0);
  const auto patches = make_fit_patterns(projector, quad, {LightShape::patches, 3}, 0.0);
  ASSERT_EQ(bars.size(), 6U);
  ASSERT_EQ(patches.size(), 9U);
  EXPECT_EQ(bars[5].id, "fit_05");
  EXPECT_EQ(bars[5].role, PatternRole::fit);
  for (std::size_t i = 0; i < bars[0].image.size(); ++i) {
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t row = 0; row < 3; ++row) {
        const bool both =
            bars[column].image.values()[i] == 255 && bars[3 + row].image.values()[i] == 255;
        ASSERT_EQ(both, patches[3 * row + column].image.values()[i] == 255)
            << "pixel " << i << ", column " << column << ", row " << row;
      }
    }
  }
  EXPECT_THAT(sentence_of([&] {
                make_fit_patterns(projector, quad, {LightShape::bars, 0}, 0.0);
              }),
              testing::HasSubstr("number of bars across an axis is 0"));
}

TEST(PatchPatterns, ADegenerateQuadIsRefused) {
  EXPECT_THAT(sentence_of([] {
                make_patch_patterns({64, 48}, {{{1, 1}, {1, 1}, {1, 1}, {1, 1}}}, 2, 0.0,
                                    PatternRole::fit, "p");
              }),
              testing::HasSubstr("corners in one line"));
}

// A corner at a pixel's centre shares that pixel between four squares; the mean over any two by two
// squares is half white.
TEST(Chessboard, CornersLieWhereTheSessionSays) {
  const ProjectedBoard board{4, 3, 8.0, {20.0, 16.5}};
  const Image<std::uint8_t> image = make_chessboard_image({70, 60}, board);
  EXPECT_EQ(image(16, 12), 0);    // top left square, black
  EXPECT_EQ(image(24, 12), 255);  // its right neighbour
  EXPECT_EQ(image(16, 20), 255);
  EXPECT_EQ(image(24, 20), 0);
  EXPECT_EQ(image(8, 12), 255);   // border of one square
  EXPECT_EQ(image(2, 12), 0);     // beyond it
  EXPECT_EQ(image(20, 12), 128);  // an edge through a pixel's centre: half of it
  EXPECT_EQ(image(20, 20), 128);
  double moment = 0.0;
  for (int y = 9; y < 25; ++y) {
    for (int x = 12; x <= 28; ++x) moment += (x == 12 || x == 28 ? 0.5 : 1.0) * image(x, y) / 255.0;
  }
  EXPECT_NEAR(moment / 256.0, 0.5, 0.01);
}

}  // namespace
}  // namespace kappamu::capture
