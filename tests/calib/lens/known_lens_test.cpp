// Lenses known from elsewhere: files as programs write them, and what a calibration makes of them.
// That a session's own calibration is read back is calibration_file_test.cpp's.
#include "calib/lens/known_lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/calib/board_scene.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;

const Lens lens{640, 480, 800.0, 805.0, 321.0, 238.0, {-0.28, 0.1, 0.001, -0.0006, 0.02}};

// As OpenCV's calibration sample writes it, corners and all.
constexpr const char* opencv_yaml = R"(%YAML:1.0
---
calibration_time: "Tue 10 Mar 2020 11:02:23"
nframes: 2
image_width: 640
image_height: 480
flags: 0
# no flags
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 800., 0., 321., 0., 805., 238., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.8e-01, 0.1, 1.0e-03, -6.0e-04,
       2.0e-02 ]
avg_reprojection_error: 4.0e-01
per_view_reprojection_errors: !!opencv-matrix
   rows: 2
   cols: 1
   dt: f
   data: [ 0.5, 0.25 ]
image_points: !!opencv-matrix
   rows: 1
   cols: 2
   dt: "2f"
   data: [ 1., 2., 3.,
       4. ]
)";

constexpr const char* ros_yaml = R"(image_width: 640
image_height: 480
camera_name: head_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [800.0, 0.0, 321.0, 0.0, 805, 238.0, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.28, 0.1, 0.001, -0.0006, 0.02]
)";

constexpr const char* lists_json = R"({"camera_matrix": [[800, 0, 321], [0, 805, 238], [0, 0, 1]],
  "dist_coeff": [[-0.28, 0.1, 0.001, -0.0006, 0.02]], "rms": 0.4})";

constexpr const char* opencv_json = R"({
  "image_width": 640, "image_height": 480,
  "camera_matrix": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d",
                    "data": [800.0, 0.0, 321.0, 0.0, 805.0, 238.0, 0.0, 0.0, 1.0]},
  "distortion_coefficients": {"type_id": "opencv-matrix", "rows": 1, "cols": 14, "dt": "d",
    "data": [-0.28, 0.1, 0.001, -0.0006, 0.02, 0, 0, 0, 0, 0, 0, 0, 0, 0]}})";

class KnownLensFile : public ::testing::Test {
 protected:
  KnownLens read(const std::string& text, const char* name = "camera.yml") const {
    std::ofstream(folder_ / name) << text;
    return read_known_lens(folder_ / name, LensUse::held);
  }
  std::string refused(std::string text, const std::string& from, const std::string& to) const {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return sentence_of([&] { read(text); });
  }
  const OwnFolder folder_;
};

TEST_F(KnownLensFile, IsReadAsOpenCvRosAndPythonWriteIt) {
  for (const char* text : {opencv_yaml, ros_yaml, lists_json, opencv_json}) {
    const Lens found = read(text).lens;
    EXPECT_EQ(found.fx, lens.fx) << text;
    EXPECT_EQ(found.fy, lens.fy) << text;
    EXPECT_EQ(found.cx, lens.cx) << text;
    EXPECT_EQ(found.cy, lens.cy) << text;
    EXPECT_EQ(found.distortion, lens.distortion) << text;
    EXPECT_EQ(found.width, text == lists_json ? 0 : 640) << text;
  }
  EXPECT_EQ(read(std::string("\xEF\xBB\xBF") + lists_json).lens.fx, lens.fx);
}

TEST_F(KnownLensFile, OfAnotherModelOrSizeIsRefused) {
  EXPECT_THAT(refused(ros_yaml, "plumb_bob", "equidistant"), HasSubstr("lens model that is not"));
  EXPECT_THAT(refused(opencv_json, "0, 0]}}", "0, 0.1]}}"), HasSubstr("lens model that is not"));
  EXPECT_THAT(refused(ros_yaml, "camera_matrix", "matrix"), HasSubstr("has no camera_matrix"));
  EXPECT_THAT(refused(lists_json, "dist_coeff", "other"), HasSubstr("has no distortion_coeff"));
  EXPECT_THAT(refused(lists_json, "[800, 0, 321]", "[800, 3, 321]"), HasSubstr("is not (fx 0 cx"));
  EXPECT_THAT(refused(lists_json, "[800, 0, 321]", "[-800, 0, 321]"), HasSubstr("positive fx"));
  EXPECT_THAT(sentence_of([&] { read("<?xml version=\"1.0\"?>"); }), HasSubstr("save it as YAML"));
  const KnownLens known = read(ros_yaml);
  EXPECT_THAT(sentence_of([&] { require_size(known, 1280, 960); }),
              HasSubstr("camera.yml: is of pictures of 640 x 480 pixels, and the photographs have "
                        "1280 x 960 pixels; give the lens for this size"));
  require_size(known, 640, 480);
}

BoardView seen_once(double noise_px, std::mt19937& random, double turn = 0.0) {
  const Rigid pose = testing::tilted(0.4, -0.3, turn, {10.0, -5.0, 500.0}, {100.0, 62.5, 0.0});
  return testing::seen(lens, pose, 9, 6, 25.0, noise_px, random);
}

// A pose's stated deviation is held against its spread over noise.
TEST(KnownLensHeld, OneViewIsEnoughAndItsPoseScattersAsStated) {
  const KnownLens known{lens, LensUse::held, "camera.yml"};
  std::mt19937 random(3);
  constexpr int repeats = 60;
  double square = 0.0, stated = 0.0, mean = 0.0;
  for (int k = 0; k < repeats; ++k) {
    const CameraCalibration found =
        calibrate_camera({seen_once(0.1, random)}, 25.0, 640, 480, std::nullopt, known);
    EXPECT_EQ(found.lens.fx, lens.fx);
    EXPECT_EQ(found.lens.distortion, lens.distortion);
    EXPECT_EQ(found.covariance.norm(), 0.0);
    EXPECT_EQ(to_string(found.model), "held");
    EXPECT_NEAR(found.rms_px, 0.1 * std::sqrt(2.0), 0.05);
    const Rigid truth = testing::tilted(0.4, -0.3, 0.0, {10.0, -5.0, 500.0}, {100.0, 62.5, 0.0});
    const double error = found.camera_from_board[0].translation.z() - truth.translation.z();
    const Eigen::Index z = lens_numbers + 2 + 5;
    square += error * error / repeats;
    mean += error / repeats;
    stated += found.joint_covariance(z, z) / repeats;
  }
  std::printf("z: mean %.4f, spread %.4f, stated %.4f mm\n", mean, std::sqrt(square),
              std::sqrt(stated));
  // The spread of sixty is known to 1 / sqrt(120) of itself: four standard errors.
  EXPECT_NEAR(std::sqrt(square / stated), 1.0, 4.0 / std::sqrt(2.0 * repeats));
}

TEST(KnownLensStart, LeadsWhereNoStartDoes) {
  std::mt19937 random(5);
  std::vector<BoardView> views;
  for (const Rigid& pose : testing::board_poses(9, 6, 25.0, 600.0, random)) {
    views.push_back(testing::seen(lens, pose, 9, 6, 25.0, 0.05, random));
  }
  Lens rough = lens;
  rough.fx *= 1.1;
  rough.fy *= 1.1;
  rough.distortion = {};
  const CameraCalibration plain = calibrate_camera(views, 25.0, 640, 480);
  const CameraCalibration led = calibrate_camera(views, 25.0, 640, 480, std::nullopt,
                                                 KnownLens{rough, LensUse::start, "camera.yml"});
  EXPECT_EQ(led.model, plain.model);
  constexpr double solver_px = 1e-3;
  EXPECT_NEAR(led.lens.fx, plain.lens.fx, solver_px);
  EXPECT_NEAR(led.lens.cx, plain.lens.cx, solver_px);
  EXPECT_GT(led.standard_deviation(0), 0.0);
}

}  // namespace
}  // namespace kappamu::calib
