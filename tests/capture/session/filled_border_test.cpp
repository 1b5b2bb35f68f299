// A band of pure colour at the picture's edge is no light; the same colour inside the picture is
// kept.
#include "capture/session/filled_border.h"

#include <gtest/gtest.h>

namespace kappamu::capture {
namespace {

void paint(Image<std::uint16_t>& codes, int x, int y, std::uint16_t r, std::uint16_t g,
           std::uint16_t b) {
  codes(x, y, 0) = r;
  codes(x, y, 1) = g;
  codes(x, y, 2) = b;
}

TEST(FilledBorder, HangsTogetherWithTheEdge) {
  Image<std::uint16_t> codes(20, 12, 3, 100);
  for (int x = 0; x < 20; ++x) paint(codes, x, 0, 0, 1, 254);
  for (int y = 0; y < 5; ++y) paint(codes, 7, y, 2, 0, 255);  // a tooth of the band
  paint(codes, 12, 6, 0, 0, 255);                             // a blue lamp
  paint(codes, 0, 11, 0, 100, 250);                           // deep blue at the edge, not full
  EXPECT_EQ(saturate_filled_border(codes, 255), 24U);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(codes(3, 0, c), 255);
    EXPECT_EQ(codes(7, 4, c), 255);
  }
  EXPECT_EQ(codes(12, 6, 0), 0);
  EXPECT_EQ(codes(0, 11, 0), 0);
  EXPECT_EQ(codes(3, 1, 0), 100);
}

TEST(FilledBorder, GreyPicturesHaveNone) {
  Image<std::uint16_t> codes(9, 9, 1, 0);
  codes(0, 0) = 255;
  EXPECT_EQ(saturate_filled_border(codes, 255), 0U);
}

}  // namespace
}  // namespace kappamu::capture
