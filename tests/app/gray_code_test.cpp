// Gray codes and room light through the whole product: a simulated session without projected
// chessboards in a room that brightens, sorted by `kappamu import`, calibrated and fitted by
// `kappamu run`, shown in the report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "calib/calibration_file.h"
#include "data_synthetic/score.h"
#include "data_synthetic/simulate.h"
#include "io/read_file.h"
#include "tests/app/process.h"
#include "tests/data_synthetic/tiny_options.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class GrayCodeSession : public TemporaryFolderTest {};

/// The session's frames as a table for `kappamu import`, which then knows no order of its own.
void write_table(const capture::Session& session, const fs::path& table) {
  std::ofstream out(table);
  out << "file,shot,exposure_s\n";
  const auto add = [&](const capture::Frame& frame, const std::string& shot) {
    out << frame.file << ',' << shot << ',' << frame.exposure_s << '\n';
  };
  const auto stack = [&](const std::vector<capture::Frame>& frames, const std::string& shot) {
    for (const capture::Frame& frame : frames) add(frame, shot);
  };
  const capture::Calibration& shots = session.calibration;
  for (std::size_t p = 0; p < shots.projector_planes.size(); ++p) {
    const std::string plane = "plane_" + std::to_string(p);
    const auto& code = shots.projector_planes[p].gray_code;
    for (std::size_t k = code.size(); k > 0; --k) {
      add(code[k - 1], plane + "_gray_" + std::to_string(k - 1));
    }
    add(shots.projector_planes[p].board, plane + "_board");
  }
  stack(shots.camera_boards, "board");
  for (const capture::SampleView& view : shots.sample_views) {
    add(view.frame, "sample_" + view.station);
  }
  stack(shots.dark, "dark");
  stack(shots.white_target->frames, "white");
  stack(shots.white_target->black_frames, "black");
  stack(shots.white_target->off_frames, "off");
  for (std::size_t time = 0; time < shots.ambient.size(); ++time) {
    stack(shots.ambient[time], "ambient_" + std::to_string(time));
  }
  stack(shots.colour_chart->frames, "chart");
  for (const capture::Pattern& pattern : session.patterns) stack(pattern.frames, pattern.id);
}

TEST_F(GrayCodeSession, IsImportedCalibratedFittedAndShown) {
  synthetic::SimulationOptions options = synthetic::tiny_options();
  options.plane_light = capture::PlaneLight::gray_code;
  options.room_light = 0.01;
  options.room_change = 0.2;
  options.rays_per_side = 2;
  options.validation = false;
  options.holdout = 0;
  Progress silent;
  synthetic::simulate(options, folder() / "capture", "reference", silent);
  const fs::path simulated = folder() / "capture/session";
  write_table(capture::read_session(simulated), folder() / "shots.csv");
  fs::create_directories(folder() / "plan");
  fs::copy(simulated / "session.json", folder() / "plan/session.json");
  fs::copy(simulated / "patterns", folder() / "plan/patterns");
  fs::remove(simulated / "session.json");

  const ProcessResult imported =
      kappamu("import " + simulated.string() + " --plan " + (folder() / "plan").string() + " -o " +
              simulated.string() + " --table " + (folder() / "shots.csv").string());
  ASSERT_EQ(imported.exit_code, 0) << imported.standard_error;
  const fs::path run = folder() / "run";
  const ProcessResult result =
      kappamu("run " + simulated.string() + " -o " + run.string() + " --device reference");
  ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 3) << result.standard_error;

  const calib::CalibrationResult found = calib::load_calibration(run / "calibration");
  ASSERT_EQ(found.gray_code.size(), 8U);
  for (const calib::GrayCodeView& view : found.gray_code) EXPECT_GT(view.points, 100) << view.name;
  EXPECT_FALSE(found.gray_code_check_px) << "no chessboard was projected";
  ASSERT_TRUE(found.white.room_light);
  EXPECT_NEAR(*found.white.room_light, options.room_light, 0.05 * options.room_light);
  EXPECT_THAT(result.standard_error, HasSubstr("the room's light was"));
  const synthetic::CalibrationErrors errors =
      synthetic::calibration_errors(found, synthetic::read_truth(folder() / "capture/truth"));
  std::printf("projector RMS %.3f px, focal length off by %.3f %%, lit face by %.3f px\n",
              found.projector.rms_px, 100.0 * errors.projector_focal_relative,
              errors.projector_face_px);
  EXPECT_LT(found.projector.rms_px, 0.3);
  EXPECT_LT(errors.projector_face_px, 0.5);

  const std::string page = io::read_text(run / "report.html");
  EXPECT_THAT(page, HasSubstr("Gray codes: how legible"));
  EXPECT_THAT(page, HasSubstr("plane_07_gray_00.png: "));
}

}  // namespace
}  // namespace kappamu::app
