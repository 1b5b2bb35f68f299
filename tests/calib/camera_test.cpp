#include "calib/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "board_scene.h"
#include "core/error.h"
#include "io/image_file.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using testing::board_poses;
using ::testing::HasSubstr;
using testing::seen;

constexpr int columns = 9;
constexpr int rows = 6;
constexpr double square_mm = 4.0;

Lens camera_lens() {
  return {640, 480, 820.0, 823.0, 322.0, 236.0, {-0.12, 0.08, 0.0015, -0.001, 0.0}};
}

std::vector<BoardView> views_of(const Lens& lens, double noise_px, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<BoardView> views;
  for (const Rigid& pose : board_poses(columns, rows, square_mm, 75.0, random)) {
    views.push_back(seen(lens, pose, columns, rows, square_mm, noise_px, random));
  }
  return views;
}

TEST(Camera, ExactCornersGiveTheExactLens) {
  const Lens truth = camera_lens();
  const CameraCalibration found = calibrate_camera(views_of(truth, 0.0, 3), square_mm, truth.width,
                                                   truth.height, LensModel::full);
  // The solver's own stopping tolerances; corners pass through single precision only at the start.
  EXPECT_TRUE(found.converged);
  EXPECT_LT(found.rms_px, 1e-6);
  EXPECT_NEAR(found.lens.fx, truth.fx, 1e-4);
  EXPECT_NEAR(found.lens.fy, truth.fy, 1e-4);
  EXPECT_NEAR(found.lens.cx, truth.cx, 1e-4);
  EXPECT_NEAR(found.lens.cy, truth.cy, 1e-4);
}

TEST(Camera, ModelFollowsTheLens) {
  constexpr double noise_px = 0.1;
  constexpr int runs = 8;
  Lens lens = camera_lens();
  int too_rich = 0;
  lens.distortion = {-0.2, 0.0, 0.0, 0.0, 0.0};
  for (int run = 0; run < runs; ++run) {
    const auto found = calibrate_camera(views_of(lens, noise_px, 20 + run), square_mm, 640, 480);
    too_rich += found.model == LensModel::full ? 1 : 0;
  }
  // k3 has to pass the Bayesian criterion: P(chi2_1 > ln 1296) = 0.7 % a run.
  EXPECT_LT(too_rich, 2);
  lens.distortion = {-0.2, 0.3, 0.004, -0.003, 0.0};
  for (int run = 0; run < runs; ++run) {
    const auto found = calibrate_camera(views_of(lens, noise_px, 40 + run), square_mm, 640, 480);
    EXPECT_GE(parameter_count(found.model), parameter_count(LensModel::radial2_tangential));
  }
}

TEST(Camera, RmsIsTheNoiseThatWasAdded) {
  constexpr double noise_px = 0.1;
  const CameraCalibration found =
      calibrate_camera(views_of(camera_lens(), noise_px, 5), square_mm, 640, 480);
  // Two coordinates of noise_px each, 1296 of them: 2 % standard error, less 6 % for the
  // parameters.
  EXPECT_NEAR(found.rms_px, std::sqrt(2.0) * noise_px, 0.12 * std::sqrt(2.0) * noise_px);
  EXPECT_EQ(found.views.size(), 12U);
}

// The stated covariance against the spread of repeated calibrations from new noise.
TEST(Camera, CovarianceIsTheSpreadOfRepeatedCalibrations) {
  constexpr int runs = 40;
  constexpr double noise_px = 0.1;
  const Lens truth = camera_lens();
  std::mt19937 random(6);
  const std::vector<Rigid> poses = board_poses(columns, rows, square_mm, 75.0, random);
  Eigen::Matrix<double, 4, 1> squares = Eigen::Matrix<double, 4, 1>::Zero();
  for (int run = 0; run < runs; ++run) {
    std::vector<BoardView> views;
    for (const Rigid& pose : poses) {
      views.push_back(seen(truth, pose, columns, rows, square_mm, noise_px, random));
    }
    const CameraCalibration found =
        calibrate_camera(views, square_mm, 640, 480, LensModel::radial2_tangential);
    const double deviations[4] = {found.lens.fx - truth.fx, found.lens.fy - truth.fy,
                                  found.lens.cx - truth.cx, found.lens.cy - truth.cy};
    for (int k = 0; k < 4; ++k) {
      squares[k] += std::pow(deviations[k] / found.standard_deviation(k), 2);
    }
  }
  // Mean of 40 squared standard normals: standard error sqrt(2/40) = 0.22; four of them.
  const Eigen::Matrix<double, 4, 1> reduced = squares / runs;
  for (int k = 0; k < 4; ++k) {
    EXPECT_GT(reduced[k], 1.0 - 3.5 * 0.22) << "parameter " << k;
    EXPECT_LT(reduced[k], 1.0 + 3.5 * 0.22) << "parameter " << k;
  }
}

TEST(Camera, TwoViewsAreRefusedInOneSentence) {
  std::vector<BoardView> views = views_of(camera_lens(), 0.0, 7);
  views.resize(2);
  const std::string sentence = sentence_of([&] { calibrate_camera(views, square_mm, 640, 480); });
  EXPECT_THAT(sentence, HasSubstr("2 board photographs given and at least 3 are needed"));
  EXPECT_THAT(sentence, HasSubstr("calibration.camera_boards"));
}

TEST(Camera, ViewsWithoutTiltDoNotDetermineTheLens) {
  std::mt19937 random(8);
  std::vector<BoardView> views;
  for (int view = 0; view < 5; ++view) {
    const Rigid pose = testing::tilted(0.0, 0.0, 0.1 * view, {2.0 * view, 0.0, 80.0 + 5.0 * view},
                                       {16.0, 10.0, 0.0});
    views.push_back(seen(camera_lens(), pose, columns, rows, square_mm, 0.05, random));
  }
  EXPECT_THROW(
      {
        const CameraCalibration found = calibrate_camera(views, square_mm, 640, 480);
        // A calibration that admits it knows nothing is as good as a refusal.
        if (found.standard_deviation(0) > 0.05 * found.lens.fx) throw InputError("undetermined");
      },
      InputError);
}

TEST(Camera, BoardPoseIsRecovered) {
  std::mt19937 random(9);
  const Lens lens = camera_lens();
  const Rigid pose = testing::tilted(0.4, -0.2, 0.1, {3.0, -2.0, 80.0}, {16.0, 10.0, 0.0});
  const BoardView view = seen(lens, pose, columns, rows, square_mm, 0.0, random);
  const Rigid found = board_pose(lens, view.corners, square_mm, "synthetic");
  // Corners pass through single precision in OpenCV.
  EXPECT_LT((found.translation - pose.translation).norm(), 1e-2);
  EXPECT_LT((found.rotation - pose.rotation).norm(), 1e-3);
}

// Real photographs, against OpenCV on the same pictures (shared/data, SOURCE.md there).
TEST(Camera, RealBoardsAreExplainedAsWellAsByOpenCv) {
  const std::filesystem::path folder =
      std::filesystem::path(KAPPAMU_SOURCE_DIR) / "../shared/data/chessboard-opencv-left";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real boards at " << folder;
  // Corners as the peer finds them (11 x 11 window, no smoothing), and as we do.
  std::vector<BoardView> views;
  std::vector<BoardView> smoothed;
  for (const char* number :
       {"01", "02", "03", "04", "05", "06", "07", "08", "09", "11", "12", "13", "14"}) {
    const std::filesystem::path file = folder / (std::string("left") + number + ".jpg");
    const Image<std::uint16_t> codes = io::read_code_image(file);
    Image<float> image(codes.width(), codes.height(), codes.channels());
    for (std::size_t k = 0; k < codes.size(); ++k) {
      image.values()[k] = static_cast<float>(codes.values()[k]) / 255.0F;
    }
    const std::string name = file.filename().string();
    const Image<float> grey = to_grey(image);
    views.push_back({name, find_chessboard(grey, 9, 6, name, {5, 0.0})});
    smoothed.push_back({name, find_chessboard(grey, 9, 6, name)});
  }
  const auto report = [](const char* name, const CameraCalibration& c) {
    std::printf(
        "%-22s RMS %.4f px  fx %.3f +- %.2f  fy %.3f +- %.2f  cx %.3f +- %.2f  cy %.3f +- "
        "%.2f  d %.4f %.4f %.4f %.4f %.4f\n",
        name, c.rms_px, c.lens.fx, c.standard_deviation(0), c.lens.fy, c.standard_deviation(1),
        c.lens.cx, c.standard_deviation(2), c.lens.cy, c.standard_deviation(3),
        c.lens.distortion[0], c.lens.distortion[1], c.lens.distortion[2], c.lens.distortion[3],
        c.lens.distortion[4]);
  };
  const CameraCalibration full = calibrate_camera(views, 25.0, 640, 480, LensModel::full);
  const CameraCalibration radial = calibrate_camera(views, 25.0, 640, 480, LensModel::radial2);
  const CameraCalibration chosen = calibrate_camera(views, 25.0, 640, 480);
  report("k1 k2 p1 p2 k3", full);
  report("k1 k2", radial);
  report("chosen by criterion", chosen);
  const CameraCalibration ours = calibrate_camera(smoothed, 25.0, 640, 480);
  report("chosen, our corners", ours);
  EXPECT_LE(ours.rms_px, full.rms_px);
  // OpenCV 4.6's root mean squares on the same pictures and models, to its printed digits.
  constexpr double opencv_full_rms_px = 0.1954;
  constexpr double opencv_radial_rms_px = 0.2042;
  constexpr double printed_digit_px = 5e-5;
  EXPECT_LE(full.rms_px, opencv_full_rms_px + printed_digit_px);
  EXPECT_LE(radial.rms_px, opencv_radial_rms_px + printed_digit_px);
  // Its focal length, within its own stated standard deviation.
  EXPECT_NEAR(full.lens.fx, 532.827, 0.64);
  EXPECT_NEAR(full.lens.fy, 532.946, 0.67);
}

}  // namespace
}  // namespace kappamu::calib
