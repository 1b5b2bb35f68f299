// What is printed is as large as the plan says.
#include "capture/rig/printables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

using testing::HasSubstr;

struct Square {
  double x, y, width, height;
};

std::vector<Square> squares_of(const std::string& pdf) {
  std::vector<Square> squares;
  const std::regex rectangle(R"((\S+) (\S+) (\S+) (\S+) re\n)");
  for (std::sregex_iterator at(pdf.begin(), pdf.end(), rectangle), end; at != end; ++at) {
    squares.push_back(
        {std::stod((*at)[1]), std::stod((*at)[2]), std::stod((*at)[3]), std::stod((*at)[4])});
  }
  return squares;
}

std::array<double, 2> page_mm(const std::string& pdf) {
  std::smatch found;
  if (!std::regex_search(pdf, found, std::regex(R"(MediaBox \[0 0 (\S+) (\S+)\])"))) return {};
  return {std::stod(found[1]) * 25.4 / 72.0, std::stod(found[2]) * 25.4 / 72.0};
}

TEST(Printables, BoardHasItsSquaresAtTheirSizeOnAUsualPage) {
  struct Case {
    Board board;
    double width, height;
  };
  for (const auto& [board, width, height] :
       {Case{{9, 6, 4.0}, 210.0, 297.0}, Case{{9, 6, 20.0}, 297.0, 210.0},
        Case{{11, 8, 25.0}, 420.0, 297.0}, Case{{7, 5, 100.0}, 1010.0, 822.0}}) {
    const std::string pdf = board_pdf(board);
    EXPECT_NEAR(page_mm(pdf)[0], width, 1e-2);
    EXPECT_NEAR(page_mm(pdf)[1], height, 1e-2);
    const std::vector<Square> squares = squares_of(pdf);
    ASSERT_EQ(squares.size(),
              static_cast<std::size_t>((board.columns + 1) * (board.rows + 1) + 1) / 2);
    for (const Square& square : squares) {
      EXPECT_EQ(square.width, board.square_mm);
      EXPECT_EQ(square.height, board.square_mm);
      const double column = (square.x - squares[0].x) / board.square_mm;
      const double row = (square.y - squares[0].y) / board.square_mm;
      EXPECT_NEAR(column, std::round(column), 1e-3);
      EXPECT_EQ((std::lround(column) + std::lround(row)) % 2, 0);
      // White around: a square, less where only the page ends there.
      EXPECT_GE(square.x, board.square_mm);
      EXPECT_GE(square.y, board.square_mm);
      EXPECT_LE(square.x + 2 * board.square_mm, width + 1e-6);
      EXPECT_LE(square.y + 2 * board.square_mm, height + 1e-6);
    }
    EXPECT_THAT(pdf, HasSubstr("Print at 100 %"));
  }
}

TEST(Printables, PdfNamesThePlacesOfItsObjects) {
  const std::string pdf = board_pdf({9, 6, 4.0});
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref\n") + 10));
  ASSERT_EQ(pdf.substr(table, 4), "xref");
  for (int object = 1; object <= 5; ++object) {
    // After "xref\n0 6\n" come lines of 20 bytes, the first for object 0.
    const std::size_t line = table + 9 + 20 * static_cast<std::size_t>(object);
    const std::size_t place = std::stoul(pdf.substr(line, 10));
    EXPECT_EQ(pdf.substr(place, 7), std::to_string(object) + " 0 obj");
  }
}

TEST(Printables, OtherBoardsAreNotDrawn) {
  Board board{9, 6, 4.0};
  board.kind = BoardKind::circles;
  EXPECT_THAT(sentence_of([&] { board_pdf(board); }), HasSubstr("only a chessboard"));
}

TEST(Printables, SketchNamesFacesAndStations) {
  Sample sample;
  sample.grid = {20, 16, 8};
  sample.voxel_mm = 0.5;
  const std::string back = rig_sketch(sample, Setup::back_lit);
  EXPECT_THAT(back, HasSubstr("block, 10 x 8 x 4 mm along x, y, z"));
  EXPECT_THAT(back, HasSubstr("camera at station back"));
  EXPECT_THAT(back, HasSubstr("front: z-"));
  const std::string front = rig_sketch(sample, Setup::front_lit);
  EXPECT_THAT(front, HasSubstr("lit and seen"));
  EXPECT_EQ(front.find("station back"), std::string::npos);
}

}  // namespace
}  // namespace kappamu::capture
