// Boards of every kind, drawn by the simulator: corners where they were drawn, parts of boards, and
// the sentences about boards of another make.
#include "calib/targets/find_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "calib/targets/board_shape.h"
#include "calib/targets/charuco.h"
#include "calib/targets/chessboard.h"
#include "data_synthetic/rig/render.h"
#include "data_synthetic/rig/targets.h"
#include "tests/calib/board_scene.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using capture::BoardKind;
using ::testing::HasSubstr;

Lens camera_lens(int scale = 1) {
  return {640 * scale,
          480 * scale,
          1900.0 * scale,
          1902.0 * scale,
          325.0 * scale,
          235.0 * scale,
          {-0.3, 0.8, 0.0008, -0.0006, 0.0}};
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
                        unsigned seed = 1, int scale = 1) {
  const synthetic::RayTable rays(camera_lens(scale), 3);
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
Miss miss(const BoardCorners& corners, const capture::Board& board, const Rigid& pose,
          int scale = 1) {
  const Lens lens = camera_lens(scale);
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

// Larger than what the markers' detector is given at first: of the second board it sees a part.
TEST(FindBoard, CharucoCornersOfALargePictureLieWhereTheyWereDrawn) {
  const capture::Board board = board_of(BoardKind::charuco);
  constexpr int scale = 4;
  for (const double x : {0.5, 8.0}) {
    const Rigid pose = pose_of(board, 0.3, 0.1, {x, -0.3, 85.0});
    const BoardCorners corners = find_board(picture_of(board, pose, 3, scale), board, "large");
    const Miss one = miss(corners, board, pose, scale);
    std::printf("%zu corners: RMS %.4f px, largest %.4f px\n", corners.pixels.size(), one.rms,
                one.largest);
    EXPECT_EQ(corners.pixels.size() == 54, x < 1.0);
    EXPECT_LT(one.rms, 0.05);
    EXPECT_LT(one.largest, 0.15);
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
                                    "DICT_4X4_50: correct the board's dictionary"));
  told = board;
  told.columns = 8;
  EXPECT_THAT(says(told), HasSubstr("its markers lie as on a board of 9 inner corners per row, not "
                                    "8: correct what is stated of the board"));
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

TEST(FindBoard, CircleGridOfAnotherMakeIsNamed) {
  const capture::Board board = board_of(BoardKind::circles);
  const Image<float> image = picture_of(board, pose_of(board, 0.2, 0.1, {0.0, 0.0, 90.0}));
  const auto says = [](const Image<float>& picture, const capture::Board& told) {
    return sentence_of([&] { find_board(picture, told, "b.png"); });
  };
  capture::Board told = board;
  for (const int rows : {5, 7}) {
    told.rows = rows;
    EXPECT_THAT(says(image, told), HasSubstr("but a circle grid of 9 x 6 dots: correct"));
  }
  told = board_of(BoardKind::asymmetric_circles);
  EXPECT_THAT(says(image, told), HasSubstr("b.png: no asymmetric circle grid of 5 x 9 dots found, "
                                           "but a circle grid of 9 x 6 dots: correct the board's "
                                           "kind, columns and rows"));
  const Image<float> other = picture_of(told, pose_of(told, 0.2, 0.1, {0.0, 0.0, 90.0}));
  EXPECT_THAT(says(other, board), HasSubstr("but an asymmetric circle grid of 5 x 9 dots"));
  Image<float> part = image;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 320; ++x) part(x, y) = 0.8F;
  }
  EXPECT_THAT(says(part, board),
              HasSubstr("light ones); take the picture again with the whole grid in view"));
}

// Half a turn leaves staggered grids of even rows alone and others not; OpenCV's own order fails
// for even ones of six rows or more in some directions.
TEST(FindBoard, StaggeredGridsOfAnySizeAreOrderedHoweverTurned) {
  for (const auto& [columns, rows] : {std::array{4, 10}, std::array{4, 11}, std::array{3, 6},
                                      std::array{5, 8}, std::array{6, 3}, std::array{8, 4}}) {
    const capture::Board board{
        columns, rows, 16.0 / std::max(2 * columns, rows), BoardKind::asymmetric_circles, 0.0, ""};
    for (int turn = 0; turn < 6; ++turn) {
      const double angle = 0.3 + turn * 2.0 * 3.14159265 / 6.0;
      const Rigid pose = pose_of(board, turn % 2 == 0 ? 0.5 : -0.3, angle, {0.3, -0.2, 90.0});
      const BoardCorners corners = find_board(picture_of(board, pose), board, "staggered");
      // With even rows the upright one of two orders is told, which may be the pose's other half.
      const capture::Board& seen = board;
      const double direct = miss(corners, seen, pose).largest;
      BoardCorners turned = corners;
      std::reverse(turned.pixels.begin(), turned.pixels.end());
      const double half = rows % 2 == 0 ? miss(turned, seen, pose).largest : direct;
      EXPECT_LT(std::min(direct, half), 0.15) << columns << " x " << rows << " turn " << turn;
      EXPECT_TRUE(rows % 2 == 1 || corners.at(columns - 1, 0).x() > corners.at(0, 0).x());
    }
  }
}

TEST(FindBoard, LightDotsOnDarkLieWhereDarkOnesWould) {
  for (const BoardKind kind : {BoardKind::circles, BoardKind::asymmetric_circles}) {
    const capture::Board board = board_of(kind);
    const Rigid pose = pose_of(board, 0.3, 0.2, {0.0, 0.0, 90.0});
    Image<float> image = picture_of(board, pose);
    for (float& value : image.values()) value = 0.9F - value;
    EXPECT_LT(miss(find_board(image, board, "light"), board, pose).largest, 0.12)
        << to_string(kind);
  }
}

/// ChArUco as OpenCV before 4.6 drew it, where that differs: the first square light, markers
/// numbered by rows over the light squares.
Image<float> legacy_picture(const capture::Board& board, const Rigid& camera_from_board) {
  const int squares = board.columns + 1;
  std::vector<MarkerCells> markers;
  for (int id = 0; id < squares * (board.rows + 1) / 2; ++id) {
    markers.push_back(marker_cells(board.dictionary, id));
  }
  synthetic::Quad quad = synthetic::board_quad(board, camera_from_board);
  const auto ink = [=](const Eigen::Vector2d& at) {  // in squares from the sheet's first corner
    const int column = static_cast<int>(std::floor(at.x()));
    const int row = static_cast<int>(std::floor(at.y()));
    if (column < 0 || row < 0 || column > board.columns || row > board.rows) return false;
    if ((column + row) % 2 == 1) return true;
    const MarkerCells& marker = markers[(row * squares + 1) / 2 + column / 2];
    const double side = board.marker_mm / board.square_mm;
    const Eigen::Vector2d cell =
        (at - Eigen::Vector2d(column, row) - Eigen::Vector2d::Constant(0.5 * (1.0 - side))) *
        (marker.side / side);
    if (cell.minCoeff() < 0.0 || cell.maxCoeff() >= marker.side) return false;
    return marker.light[static_cast<std::size_t>(cell.y()) * marker.side +
                        static_cast<std::size_t>(cell.x())] == 0;
  };
  quad.albedo = [=](const Eigen::Vector2d& position, const Eigen::Vector2d& footprint) {
    constexpr int samples = 4;
    double covered = 0.0;
    for (int k = 0; k < samples * samples; ++k) {
      const Eigen::Vector2d offset((k % samples + 0.5) / samples - 0.5,
                                   (k / samples + 0.5) / samples - 0.5);
      const Eigen::Vector2d place = position + offset.cwiseProduct(footprint);
      covered += ink(place / board.square_mm + Eigen::Vector2d::Ones()) ? 1.0 : 0.0;
    }
    const double value = 0.85 - 0.8 * covered / (samples * samples);
    return std::array<double, 3>{value, value, value};
  };
  static const Lens lens = camera_lens();
  static const synthetic::RayTable rays(lens, 3);
  synthetic::Illumination light;
  light.ambient = 3.14;
  return to_grey(synthetic::render_quads(rays, Rigid{}, {quad}, light));
}

TEST(FindBoard, BothLayoutsOfCharucoBoardsAreTold) {
  for (const int columns : {8, 9}) {
    capture::Board board = board_of(BoardKind::charuco);
    board.columns = columns;
    board.rows = 5;  // six rows of squares: the layouts differ
    for (const double turn : {0.1, 1.7}) {
      // The second view shows a part of the board.
      const Rigid pose = pose_of(board, 0.2, turn, {turn > 1.0 ? 7.0 : 0.0, 0.0, 85.0});
      for (const bool legacy : {false, true}) {
        const Image<float> image = legacy ? legacy_picture(board, pose) : picture_of(board, pose);
        const BoardCorners corners = find_board(image, board, "layout");
        EXPECT_EQ(corners.light_first, legacy) << columns << " columns, turned by " << turn;
        EXPECT_LT(miss(corners, board, pose).largest, 0.15);
        EXPECT_GE(corners.pixels.size(), 12U);
      }
    }
  }
  capture::Board board = board_of(BoardKind::charuco);
  board.rows = 5;
  const Image<float> image = legacy_picture(board, pose_of(board, 0.2, 0.1, {0.0, 0.0, 90.0}));
  board.columns = 8;
  EXPECT_THAT(sentence_of([&] { find_board(image, board, "b.png"); }),
              HasSubstr("its markers lie as on a board of 9 inner corners per row, not 8"));
}

}  // namespace
}  // namespace kappamu::calib
