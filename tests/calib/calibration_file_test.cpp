// A calibration's YAML, damaged.
#include "calib/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <tuple>

#include "io/read_file.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Numbers that no such field holds, each in a file that is otherwise good.
TEST(CalibrationFile, NumbersThatNoFieldHoldsAreNamed) {
  const OwnFolder folder;
  CalibrationResult calibration;
  for (SamplePose* pose : {&calibration.calibration_pose, &calibration.pattern_pose}) {
    pose->corners_px.fill(Eigen::Vector2d::Zero());
  }
  calibration.radiometry.bit_depth = 4;
  calibration.radiometry.black_level = {0.0};
  calibration.radiometry.noise.resize(1);
  calibration.radiometry.response.linear = {std::vector<double>(16, 0.5)};
  calibration.radiometry.reports.resize(1);
  calibration.scale = {1.0};
  calibration.white.scale = calibration.white.residual_rms = {1.0};
  calibration.projector_curve = ProjectorCurve{{0, 255}, {{0.0, 1.0}}};
  save_calibration(folder.path(), calibration);
  EXPECT_NO_THROW(load_calibration(folder.path()));
  for (const auto& [name, good, bad, expected] :
       {std::tuple{"radiometry.yml", "white_pixels: 0.", "white_pixels: 6e105",
                   "white_pixels holds 6e+105 for a whole number"},
        {"radiometry.yml", "white_pixels: 0.", "white_pixels: -1.", "white_pixels holds -1."},
        {"radiometry.yml", "black_measured: 0.", "black_measured: 2.", "black_measured holds 2."},
        {"radiometry.yml", "[ 0., 255. ]", "[ 0., 1e80 ]", "projector_values holds 1e+80"},
        {"response.yml", "bit_depth: 4.", "bit_depth: 40.", "bit_depth holds 40."},
        {"response.yml", "reports_count: 1.", "reports_count: 0.5", "reports_count holds 0.5"},
        {"camera.yml", "image_width: 0.", "image_width: 1e10", "image_width holds 1e+10"}}) {
    const std::filesystem::path file = folder / name;
    const std::string whole = io::read_text(file);
    const std::size_t at = whole.find(good);
    ASSERT_NE(at, std::string::npos) << good << " is not in\n" << whole;
    std::ofstream(file) << std::string(whole).replace(at, std::string(good).size(), bad);
    const std::string sentence = sentence_of([&] { load_calibration(folder.path()); });
    EXPECT_THAT(sentence, HasSubstr(expected));
    EXPECT_THAT(sentence, HasSubstr(name));
    std::ofstream(file) << whole;
  }
}

// Written before they were measured, or where nothing tells them.
TEST(CalibrationFile, ErrorsOfTheWhiteTargetMayBeAbsent) {
  const OwnFolder folder;
  CalibrationResult calibration;
  for (SamplePose* pose : {&calibration.calibration_pose, &calibration.pattern_pose}) {
    pose->corners_px.fill(Eigen::Vector2d::Zero());
  }
  calibration.white.level_error = 2e-3;
  save_calibration(folder.path(), calibration);
  EXPECT_THAT(io::read_text(folder / "radiometry.yml"), Not(HasSubstr("white_smooth_error")));
  const CalibrationResult back = load_calibration(folder.path());
  EXPECT_FALSE(back.white.smooth_error.has_value());
  EXPECT_EQ(back.white.level_error, 2e-3);
}

}  // namespace
}  // namespace kappamu::calib
