// Gray codes: our reading against OpenCV's, located points against the simulator's truth, and the
// projector against a real rig's (shared/data, SOURCE.md there).
#include "calib/projector/gray_code.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/structured_light.hpp>

#include "calib/projector/bundle_adjustment.h"
#include "calib/projector/projector.h"
#include "calib/targets/chessboard.h"
#include "capture/rig/shoot.h"
#include "data_synthetic/rig/render.h"
#include "data_synthetic/rig/rig.h"
#include "data_synthetic/rig/targets.h"
#include "io/image/image_file.h"
#include "tests/calib/board_scene.h"
#include "tests/calib/projector/coded_plane.h"
#include "tests/data_synthetic/tiny_options.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;
using testing::held;
using testing::Misses;
using testing::misses;
using testing::photographs;

cv::Mat bytes(const Image<float>& image, double white) {
  cv::Mat out(image.height(), image.width(), CV_8U);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      out.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255.0 * image(x, y) / white);
    }
  }
  return out;
}

TEST(GrayCode, FramesAreThoseOfOpenCv) {
  const capture::Projector projector{640, 480};
  const auto code =
      cv::structured_light::GrayCodePattern::create(projector.width, projector.height);
  std::vector<cv::Mat> frames;
  code->generate(frames);
  const auto ours = capture::make_gray_code_images(projector);
  ASSERT_EQ(ours.size(), frames.size() + 2);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    int different = 0;
    for (int y = 0; y < projector.height; ++y) {
      for (int x = 0; x < projector.width; ++x) {
        different += frames[k].at<std::uint8_t>(y, x) == ours[k](x, y) ? 0 : 1;
      }
    }
    EXPECT_EQ(different, 0) << k;
  }
}

TEST(GrayCode, CodesAreOpenCvs) {
  const synthetic::Rig rig = synthetic::make_rig(synthetic::tiny_options());
  const std::vector<Image<float>> frames = photographs(
      rig, rig.world_from_plane[2], capture::make_gray_code_images(rig.projector_size), 3);
  const ProjectorMap map = decode_gray_code(held(frames), rig.projector_size);
  const auto code = cv::structured_light::GrayCodePattern::create(rig.projector_size.width,
                                                                  rig.projector_size.height);
  code->setWhiteThreshold(5);
  std::vector<cv::Mat> pictures;
  const auto& white = frames[frames.size() - 2].values();
  const float brightest = *std::max_element(white.begin(), white.end());
  for (std::size_t k = 0; k + 2 < frames.size(); ++k) {
    pictures.push_back(bytes(frames[k], brightest));
  }
  int compared = 0;
  int different = 0;
  for (int y = 0; y < map.quality.height(); y += 3) {
    for (int x = 0; x < map.quality.width(); x += 3) {
      cv::Point pixel;
      if (map.quality(x, y) <= 0.0F || code->getProjPixel(pictures, x, y, pixel)) continue;
      const cv::Point2f ours(map.pixel(x, y, 0), map.pixel(x, y, 1));
      // OpenCV reads bytes: what it takes for legible may not be so to us.
      if (std::floor(ours.x) != ours.x || std::floor(ours.y) != ours.y) continue;
      ++compared;
      different += cv::Point2f(pixel) == ours ? 0 : 1;
    }
  }
  EXPECT_GT(compared, 2000);
  EXPECT_EQ(different, 0);
}

// On the second plane, tilted more, the finest bit is legible in half of the pixels only.
TEST(GrayCode, PointsLieWhereTheProjectorThrowsThem) {
  const synthetic::Rig rig = synthetic::make_rig(synthetic::tiny_options());
  const capture::ProjectedBoard lattice = map_lattice(rig.projector_size);
  for (const std::size_t p : {std::size_t{2}, std::size_t{3}}) {
    const Rigid& plane = rig.world_from_plane[p];
    const ProjectorMap map = decode_gray_code(
        held(photographs(rig, plane, capture::make_gray_code_images(rig.projector_size), 3)),
        rig.projector_size);
    const Misses found = misses(rig, plane, lattice, mapped_corners(map, lattice, "gray"));
    std::printf("%zu of %d points, RMS %.4f px, largest %.4f px, legible in %.0f %%\n",
                found.points, lattice.columns * lattice.rows, found.rms_px, found.largest_px,
                100.0 * map.legible_share());
    EXPECT_GT(found.points, 300U) << p;
    EXPECT_LT(found.rms_px, 0.04) << p;
    EXPECT_LT(found.largest_px, 0.15) << p;
  }
}

TEST(GrayCode, DarkCodesAreOneSentenceNamingFileAndFix) {
  const capture::Projector projector{640, 480};
  const std::vector<Image<float>> dark(
      static_cast<std::size_t>(capture::gray_code_frames(projector)),
      Image<float>(80, 60, 1, 0.1F));
  const std::string sentence = sentence_of([&] {
    mapped_corners(decode_gray_code(held(dark), projector), map_lattice(projector),
                   "calibration/plane_02_gray_00.png");
  });
  EXPECT_THAT(sentence, HasSubstr("calibration/plane_02_gray_00.png: the code is legible in 0 "
                                  "% of the picture and locates 0 of"));
  EXPECT_THAT(sentence, HasSubstr("photograph the plane again with the room light off"));
}

/// The peer's corners and codes are OpenCV's; SOURCE.md gives its camera and projector.
TEST(RealGrayCode, ProjectorAgreesWithThePeers) {
  const std::filesystem::path folder =
      std::filesystem::path(KAPPAMU_SOURCE_DIR) / "../shared/data/procam-graycode-kamino410";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const capture::Projector projector{1024, 768};
  // The rows' code is of 1024: ten bits, as 768 rows need.
  const capture::Board board{9, 7, 75.0};
  const capture::ProjectedBoard lattice = map_lattice(projector);
  std::vector<BoardView> views;
  std::vector<PlaneView> planes;
  for (int pose = 0; pose < 5; ++pose) {
    std::vector<Image<float>> frames;
    for (int k = 0; k < capture::gray_code_frames(projector); ++k) {
      char name[64];
      std::snprintf(name, sizeof name, "capture_%d/graycode_%02d.jpg", pose, k);
      const Image<std::uint16_t> codes = io::read_code_image(folder / name);
      Image<float> image(codes.width(), codes.height(), codes.channels());
      for (std::size_t n = 0; n < codes.size(); ++n) image.values()[n] = codes.values()[n];
      frames.push_back(to_grey(image));
    }
    const std::string name = "capture_" + std::to_string(pose);
    const BoardCorners printed =
        find_chessboard(frames[frames.size() - 2], board.columns, board.rows, name);
    const ProjectorMap map = decode_gray_code(held(frames), projector);
    const BoardCorners points =
        points_on_plane(mapped_corners(map, lattice, name), printed, 1280, name);
    std::printf("%s: legible in %.1f %%, %zu of %d points\n", name.c_str(),
                100.0 * map.legible_share(), points.pixels.size(), lattice.columns * lattice.rows);
    views.push_back({name, printed});
    planes.push_back({name, printed, points});
  }
  const CameraCalibration camera =
      calibrate_camera(views, board.square_mm, 1280, 1024, LensModel::radial1);
  const ProjectorCalibration found =
      calibrate_projector(camera.lens, board, lattice, planes, projector.width, projector.height);
  const JointCalibration joint = adjust_jointly({views, board, lattice, planes}, camera, found);
  const auto print = [](const char* way, const CameraCalibration& c,
                        const ProjectorCalibration& l) {
    std::printf(
        "%s: camera RMS %.4f px, fx %.1f fy %.1f cx %.1f cy %.1f; projector RMS %.4f px "
        "(%s), fx %.1f +- %.1f fy %.1f cx %.1f +- %.1f cy %.1f +- %.1f, |T| %.2f mm\n",
        way, c.rms_px, c.lens.fx, c.lens.fy, c.lens.cx, c.lens.cy, l.rms_px,
        to_string(l.model).c_str(), l.lens.fx, std::sqrt(l.covariance(0, 0)), l.lens.fy, l.lens.cx,
        std::sqrt(l.covariance(2, 2)), l.lens.cy, std::sqrt(l.covariance(3, 3)),
        l.projector_from_station.translation.norm());
  };
  print("sequential", camera, found);
  print("joint", joint.camera, joint.projector);
  // The peer: 63 points per pose at the printed corners; ours reach beyond the board. Five poses of
  // one board leave the camera's focal length, and the distance with it, to about 1 %.
  EXPECT_LT(joint.camera.rms_px, 0.45);
  EXPECT_LT(joint.projector.rms_px, 1.0);
  EXPECT_NEAR(joint.projector.lens.fx / 1892.68, 1.0, 0.01);
  EXPECT_NEAR(joint.projector.lens.fy / 1897.86, 1.0, 0.01);
  EXPECT_NEAR(joint.projector.lens.cy, 854.01, 25.0);
  EXPECT_NEAR(joint.projector.projector_from_station.translation.norm() / 675.87, 1.0, 0.025);
}

}  // namespace
}  // namespace kappamu::calib
