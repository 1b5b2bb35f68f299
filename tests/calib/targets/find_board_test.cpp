// Boards of every kind, drawn by the simulator: corners where they were drawn, parts of boards, and
// the sentences about boards of another make.
#include "calib/targets/find_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "calib/targets/board_shape.h"
#include "calib/targets/chessboard.h"
#include "data_synthetic/rig/render.h"
#include "data_synthetic/rig/targets.h"
#include "tests/calib/board_scene.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using capture::BoardKind;
using ::testing::HasSubstr;

Lens camera_lens() {
  return {640, 480, 1900.0, 1902.0, 325.0, 235.0, {-0.3, 0.8, 0.0008, -0.0006, 0.0}};
}

capture::Board board_of(BoardKind kind) {
  capture::Board board{9, 6, 2.0, kind, 0.0, ""};
  if (kind == BoardKind::charuco) {
    board.marker_mm = 1.2;
    board.dictionary = "DICT_4X4_50";
  }
  // As wide as the others: rows at half the spacing.
  if (kind == BoardKind::asymmetric_circles) board = {5, 9, 1.8, kind, 0.0, ""};
  return board;
}

BoardShape shape_of(const capture::Board& board) {
  return {board.columns, board.rows, board.square_mm, board.kind == BoardKind::asymmetric_circles};
}

/// Pose of the board, its middle at `centre` [mm], turned in its plane by `turn` radians.
Rigid pose_of(const capture::Board& board, double tilt, double turn,
              const Eigen::Vector3d& centre) {
  const BoardShape shape = shape_of(board);
  const Eigen::Vector3d middle =
      0.5 * (shape.flat_point(0, 0) + shape.flat_point(board.columns - 1, board.rows - 1));
  return testing::tilted(tilt, -0.8 * tilt, turn, centre, middle);
}

Image<float> picture_of(const capture::Board& board, const Rigid& camera_from_board,
                        unsigned seed = 1) {
  static const Lens lens = camera_lens();
  static const synthetic::RayTable rays(lens, 3);
  synthetic::Illumination light;
  light.ambient = 3.14;
  Image<float> image = to_grey(synthetic::render_quads(
      rays, Rigid{}, {synthetic::board_quad(board, camera_from_board)}, light));
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0F, 0.008F);  // of the paper, as in a default session
  for (float& value : image.values()) value += noise(random);
  return image;
}

/// Root mean square and largest distance from the truth.
struct Miss {
  double rms = 0.0;
  double largest = 0.0;
};
Miss miss(const BoardCorners& corners, const capture::Board& board, const Rigid& pose) {
  const Lens lens = camera_lens();
  Miss result;
  for (std::size_t k = 0; k < corners.pixels.size(); ++k) {
    const auto [i, j] = corners.place(k);
    const double distance =
        (lens.project(pose * shape_of(board).flat_point(i, j)) - corners.pixels[k]).norm();
    result.rms += distance * distance / static_cast<double>(corners.pixels.size());
    result.largest = std::max(result.largest, distance);
  }
  result.rms = std::sqrt(result.rms);
  return result;
}

TEST(FindBoard, CornersOfEveryKindLieWhereTheyWereDrawn) {
  for (const BoardKind kind : {BoardKind::chessboard, BoardKind::charuco, BoardKind::circles,
                               BoardKind::asymmetric_circles}) {
    const capture::Board board = board_of(kind);
    double squares = 0.0;
    double largest = 0.0;
    double blur = 0.0;
    constexpr int views = 4;
    for (int view = 0; view < views; ++view) {
      const Rigid pose = pose_of(board, 0.15 * view, 0.1 * (view - 1), {0.5, -0.3, 90.0});
      const BoardCorners corners = find_board(picture_of(board, pose), board, "drawn");
      EXPECT_EQ(corners.pixels.size(), static_cast<std::size_t>(board.columns * board.rows));
      const Miss one = miss(corners, board, pose);
      squares += one.rms * one.rms / views;
      largest = std::max(largest, one.largest);
      blur = corners.blur_px;
    }
    std::printf("%s: RMS %.4f px, largest %.4f px, blur %.2f px\n", to_string(kind).c_str(),
                std::sqrt(squares), largest, blur);
    EXPECT_LT(std::sqrt(squares), 0.05) << to_string(kind);
    EXPECT_LT(largest, 0.12) << to_string(kind);
  }
}

TEST(FindBoard, PartOfACharucoBoardIsEnoughHoweverTurned) {
  const capture::Board board = board_of(BoardKind::charuco);
  for (const double turn : {0.0, 1.6, 3.1, -2.0}) {
    // The middle far to the right: some columns lie outside the picture.
    const Rigid pose = pose_of(board, 0.3, turn, {8.0, 3.0, 80.0});
    const BoardCorners corners = find_board(picture_of(board, pose), board, "part");
    EXPECT_GE(corners.pixels.size(), 8U) << turn;
    EXPECT_LT(corners.pixels.size(), 54U) << turn;
    EXPECT_LT(miss(corners, board, pose).largest, 0.15) << turn;
  }
}

TEST(FindBoard, PartialViewsCalibrateTheCamera) {
  const capture::Board board = board_of(BoardKind::charuco);
  const Lens lens = camera_lens();
  std::vector<BoardView> views;
  for (int view = 0; view < 12; ++view) {
    const double angle = 2.0 * 3.14159265 * view / 12.0;
    const Rigid pose =
        pose_of(board, 0.55 * std::cos(angle), 0.4 * view,
                {9.0 * std::cos(2.0 * angle), 7.0 * std::sin(2.0 * angle), 85.0 + view});
    const std::string name = "part_" + std::to_string(view);
    views.push_back({name, find_board(picture_of(board, pose, 5 + view), board, name)});
  }
  const auto partial = std::count_if(views.begin(), views.end(), [](const BoardView& view) {
    return view.corners.pixels.size() < 54;
  });
  EXPECT_GE(partial, 6);
  const CameraCalibration found = calibrate_camera(views, board.square_mm, lens.width, lens.height);
  std::printf("%td of 12 views partial: RMS %.3f px, fx %.1f +- %.1f (%.1f)\n", partial,
              found.rms_px, found.lens.fx, found.standard_deviation(0), lens.fx);
  EXPECT_LT(found.rms_px, 0.05);
  EXPECT_LT(std::abs(found.lens.fx - lens.fx), 4.0 * found.standard_deviation(0));
}

TEST(FindBoard, CharucoBoardOfAnotherMakeIsNamed) {
  const capture::Board board = board_of(BoardKind::charuco);
  const Image<float> image = picture_of(board, pose_of(board, 0.2, 0.1, {0.0, 0.0, 90.0}));
  const auto says = [&](const capture::Board& told) {
    return sentence_of([&] { find_board(image, told, "calibration/board_03.png"); });
  };
  capture::Board told = board;
  told.dictionary = "DICT_6X6_250";
  const std::string dictionary = says(told);
  EXPECT_THAT(dictionary, HasSubstr("calibration/board_03.png: no marker of DICT_6X6_250 but 35 of "
                                    "DICT_4X4_50: correct calibration.board.dictionary"));
  told = board;
  told.columns = 8;
  EXPECT_THAT(says(told), HasSubstr("its markers lie as on a board of 9 inner corners per row, not "
                                    "8: correct calibration.board in session.json"));
  told = board;
  told.rows = 3;
  EXPECT_THAT(says(told), HasSubstr("9 inner corners per row and more than 3 rows"));
}

TEST(FindBoard, MirroredOrMissingMarkersAreOneSentence) {
  const capture::Board board = board_of(BoardKind::charuco);
  Image<float> image = picture_of(board, pose_of(board, 0.2, 0.1, {0.0, 0.0, 90.0}));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width() / 2; ++x) {
      std::swap(image(x, y), image(image.width() - 1 - x, y));
    }
  }
  EXPECT_THAT(sentence_of([&] { find_board(image, board, "b.png"); }),
              HasSubstr("b.png: no ArUco marker found; take the picture again with most of the "
                        "ChArUco board in view, sharp, evenly lit and not mirrored"));
}

TEST(FindBoard, TooSmallAPartIsOneSentenceWithTheCount) {
  const capture::Board board = board_of(BoardKind::charuco);
  const Rigid pose = pose_of(board, 0.0, 0.0, {0.0, 0.0, 90.0});
  Image<float> image = picture_of(board, pose);
  // Two columns of squares are left, with one column of corners between them.
  const double edge = camera_lens().project(pose * shape_of(board).flat_point(1, 0)).x();
  for (int y = 0; y < image.height(); ++y) {
    for (int x = static_cast<int>(edge); x < image.width(); ++x) image(x, y) = 0.3F;
  }
  EXPECT_THAT(sentence_of([&] { find_board(image, board, "b.png"); }),
              HasSubstr("corners of the ChArUco board are seen between its markers and at least 8 "
                        "in two rows and columns are needed; take the picture again with more"));
}

TEST(FindBoard, CircleGridOfAnotherSizeIsOneSentenceWithTheCount) {
  capture::Board board = board_of(BoardKind::circles);
  const Image<float> image = picture_of(board, pose_of(board, 0.2, 0.1, {0.0, 0.0, 90.0}));
  board.rows = 7;
  EXPECT_THAT(sentence_of([&] { find_board(image, board, "b.png"); }),
              HasSubstr("b.png: no circle grid of 9 x 7 dots found (54 dark dots in the picture); "
                        "take the picture again"));
}

}  // namespace
}  // namespace kappamu::calib
