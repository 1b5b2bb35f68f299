// What the media of tests/cases/media.h promise: extremes, mean, and the same bits every time.
#include "tests/cases/media.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/sentence.h"

namespace kappamu::test_cases {
namespace {

using ::testing::HasSubstr;

constexpr double rounding = 1e-12;  // of a mean of logarithms over some thousand voxels
constexpr std::array<GridShape, 4> shapes{
    {{16, 16, 16, 0.5}, {31, 17, 5, 0.25}, {32, 32, 2, 1.0}, {1, 2, 37, 1.0}}};
constexpr std::array<MediumKind, 7> kinds{
    MediumKind::uniform, MediumKind::smooth, MediumKind::inclusions, MediumKind::checkerboard,
    MediumKind::layers,  MediumKind::random, MediumKind::shell};

double geometric_mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += std::log(v);
  return std::exp(sum / static_cast<double>(values.size()));
}

double extremes(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high / *low;
}

TEST(Media, KeepTheirGeometricMean) {
  for (const GridShape& shape : shapes) {
    for (const MediumKind kind : kinds) {
      const Medium m = make_medium(
          shape, {.kind = kind, .contrast = 1e6, .background_contrast = 10, .mean_kappa = 0.7});
      EXPECT_NEAR(geometric_mean(m.kappa.values()), 0.7, 0.7 * rounding) << to_string(kind);
    }
  }
}

TEST(Media, HaveExactlyTheContrastAsked) {
  for (const MediumKind kind : kinds) {
    if (kind == MediumKind::uniform) continue;
    const Medium m = make_medium(shapes[0], {.kind = kind, .contrast = 1e4});
    EXPECT_NEAR(extremes(m.kappa.values()), 1e4, 1e4 * rounding) << to_string(kind);
  }
}

TEST(Media, BallsConductAndInsulateAlikeInTheSameBackground) {
  const Medium m =
      make_medium({40, 40, 40, 0.5}, {.kind = MediumKind::inclusions, .contrast = 1e4});
  std::vector<double> kappa = m.kappa.values();
  std::sort(kappa.begin(), kappa.end());
  kappa.erase(std::unique(kappa.begin(), kappa.end()), kappa.end());
  ASSERT_EQ(kappa.size(), 3u);
  EXPECT_NEAR(kappa[1] / kappa[0], 100.0, 100.0 * rounding);
  EXPECT_NEAR(kappa[2] / kappa[1], 100.0, 100.0 * rounding);
}

TEST(Media, AShellOfContrastBelowOneConducts) {
  const Medium m = make_medium(shapes[0], {.kind = MediumKind::shell, .contrast = 0.01});
  EXPECT_NEAR(m.kappa(0, 5, 5) / m.kappa(8, 8, 8), 100.0, 100.0 * rounding);
}

TEST(Media, LayersFollowTheirAxisAndPeriod) {
  const Medium m =
      make_medium(shapes[0], {.kind = MediumKind::layers, .contrast = 100, .period = 2, .axis = 0});
  for (int x = 0; x + 1 < 16; ++x) {
    EXPECT_EQ(m.kappa(x, 3, 3) == m.kappa(x + 1, 9, 2), x % 2 == 0) << x;
  }
}

TEST(Media, AreTheSameEachTime) {
  for (const MediumKind kind : kinds) {
    const MediumSpec spec{.kind = kind, .contrast = 1e3, .seed = 7};
    EXPECT_EQ(make_medium(shapes[1], spec).kappa.values(),
              make_medium(shapes[1], spec).kappa.values());
  }
}

TEST(Media, RefuseWhatMakesNoMedium) {
  const auto refusal = [](const MediumSpec& spec) {
    return sentence_of([&] { make_medium(shapes[0], spec); });
  };
  EXPECT_THAT(refusal({.contrast = 0.0}), HasSubstr("contrast"));
  EXPECT_THAT(refusal({.mean_kappa = -1.0}), HasSubstr("mean_kappa"));
  EXPECT_THAT(refusal({.mu = -0.1}), HasSubstr("mu"));
  EXPECT_THAT(refusal({.period = 0}), HasSubstr("period"));
  EXPECT_THAT(refusal({.axis = 3}), HasSubstr("axis"));
}

TEST(PatchLight, LightsEachVoxelOnceWhenTheRasterIsFull) {
  const GridShape shape{17, 13, 4, 1.0};
  const auto light = patch_light(shape, Face::z_minus, 16);
  for (std::size_t k = 0; k < 17u * 13u; ++k) {
    double sum = 0.0;
    for (std::size_t m = 0; m < 16; ++m) sum += light[m * 17u * 13u + k];
    EXPECT_EQ(sum, 1.0) << k;
  }
}

TEST(PatchLight, EveryPatternLightsSomethingHoweverNarrowTheFace) {
  const GridShape shape{2, 1, 4, 1.0};
  const auto light = patch_light(shape, Face::z_minus, 16);
  for (std::size_t m = 0; m < 16; ++m) EXPECT_GT(light[2 * m] + light[2 * m + 1], 0.0) << m;
}

}  // namespace
}  // namespace kappamu::test_cases
