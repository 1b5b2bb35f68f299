// Pictures that lie mirrored to their light are told before a fit; right ones are not accused.
#include "inverse/data_checks/mirrored_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace kappamu::inverse {
namespace {

using testing::AllOf;
using testing::HasSubstr;

enum class Mirrored { no, x, y };

/// Bars of light across either axis and what a block makes of each: a wide blob behind it, brighter
/// on one side, on a ground that is the same for all.
SurfaceMeasurements bars(Mirrored mirrored) {
  constexpr int nx = 14, ny = 10, of_axis = 4;
  SurfaceMeasurements m;
  m.grid = {nx, ny, 5, 0.5};
  m.channels = {"grey"};
  m.patterns = 2 * of_axis;
  for (int p = 0; p < m.patterns; ++p) {
    const bool across_x = p < of_axis;
    const double width = static_cast<double>(across_x ? nx : ny) / of_axis;
    const double middle = (p % of_axis + 0.5) * width - 0.5;
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const int seen_x = mirrored == Mirrored::x ? nx - 1 - x : x;
        const int seen_y = mirrored == Mirrored::y ? ny - 1 - y : y;
        m.irradiance.push_back(std::abs((across_x ? x : y) - middle) <= 0.5 * width ? 1.0F : 0.0F);
        const double off = ((across_x ? seen_x : seen_y) - middle) / 4.0;
        const double uneven = 1.0 + 0.5 * std::sin(0.4 * seen_x + 0.2 * seen_y);
        m.value.push_back(static_cast<float>((0.02 + 0.1 * std::exp(-off * off)) * uneven));
      }
    }
  }
  m.variance.assign(m.value.size(), 1e-8F);
  return m;
}

TEST(MirroredLight, IsToldWithItsAxis) {
  EXPECT_EQ(mirrored_light(bars(Mirrored::no), 0), std::nullopt);
  const auto x = mirrored_light(bars(Mirrored::x), 0);
  const auto y = mirrored_light(bars(Mirrored::y), 0);
  ASSERT_TRUE(x && y);
  EXPECT_THAT(*x, AllOf(HasSubstr("moves towards -x where"), HasSubstr("are mirrored")));
  EXPECT_THAT(*y, HasSubstr("moves towards -y where"));
}

// Lit pixels that are masked under their pattern alone must not look like light that moves away.
TEST(MirroredLight, SaysNothingWhereMasksFollowTheLightOrTheLitFaceIsSeen) {
  SurfaceMeasurements masked = bars(Mirrored::no);
  masked.mask.resize(masked.value.size());
  for (std::size_t i = 0; i < masked.mask.size(); ++i)
    masked.mask[i] = masked.irradiance[i] == 0.0F;
  EXPECT_EQ(mirrored_light(masked, 0), std::nullopt);
  SurfaceMeasurements front_lit = bars(Mirrored::x);
  front_lit.seen_face = front_lit.lit_face;
  EXPECT_EQ(mirrored_light(front_lit, 0), std::nullopt);
}

}  // namespace
}  // namespace kappamu::inverse
