// Pictures of known mean and amplitude, demodulated. What maps make of them is
// tests/app/map_command_test.cpp.
#include "calib/sinusoid/demodulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

constexpr int width = 131, height = 97;
constexpr double two_pi = 2.0 * std::numbers::pi;
const Carrier carrier{1.0 / 16.7, 0.004};

double mean_at(int x, int y) {
  return 100.0 + 0.2 * x - 0.1 * y;
}
double amplitude_at(int, int y) {
  return 30.0 + 0.05 * y;
}

struct Defects {
  double second_harmonic = 0.0;  ///< over the amplitude
  double drift = 0.0;            ///< of the light, from the first phase on, relative
  double noise = 0.0;
};

Image<float> picture(double phase, const Defects& defects = {}, int number = 0) {
  Image<float> p(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double at = two_pi * (carrier.x * x + carrier.y * y) + phase;
      const double noise =
          uniform(key_of({5, std::uint64_t(number), std::uint64_t(x), std::uint64_t(y)})) - 0.5;
      p(x, y) = static_cast<float>(
          (1.0 + number * defects.drift) *
              (mean_at(x, y) +
               amplitude_at(x, y) * (std::cos(at) + defects.second_harmonic * std::cos(2.0 * at))) +
          defects.noise * std::sqrt(12.0) * noise);
    }
  }
  return p;
}

const Image<std::uint8_t> all_used(width, height, 1, 1);

Demodulated by_phases(int n, const Defects& defects = {}) {
  std::vector<Image<float>> pictures;
  std::vector<double> phases;
  for (int i = 0; i < n; ++i) {
    phases.push_back(two_pi * i / n);
    pictures.push_back(picture(phases.back(), defects, i));
  }
  return demodulate_phases(pictures, phases, all_used);
}

/// Largest relative error of mean and amplitude, `border` pixels in from the edge.
void expect_recovered(const Demodulated& light, double tolerance, int border) {
  for (int y = border; y < height - border; ++y) {
    for (int x = border; x < width - border; ++x) {
      ASSERT_NEAR(light.mean(x, y) / mean_at(x, y), 1.0, tolerance) << x << " " << y;
      ASSERT_NEAR(light.amplitude(x, y) / amplitude_at(x, y), 1.0, tolerance) << x << " " << y;
    }
  }
}

TEST(Demodulation, ThreeFourAndSevenPhasesAreExact) {
  constexpr double rounding = 1e-5;  // of single precision
  for (const int n : {3, 4, 7}) expect_recovered(by_phases(n), rounding, 0);
}

TEST(Demodulation, SevenPhasesLeaveTheSecondHarmonicOut) {
  const Demodulated light = by_phases(7, {0.05, 0.0, 0.0});
  expect_recovered(light, 1e-5, 0);
  EXPECT_NEAR(light.second_harmonic, 0.05, 1e-4);
}

TEST(Demodulation, ThreePhasesReportTheSecondHarmonic) {
  EXPECT_LT(by_phases(3).second_harmonic, 0.005);
  EXPECT_NEAR(by_phases(3, {0.05, 0.0, 0.0}).second_harmonic, 0.05, 0.01);
}

TEST(Demodulation, DriftLeavesStripesThatAreReported) {
  EXPECT_LT(by_phases(3).stripes, 0.005);  // the mean's own slope
  EXPECT_GT(by_phases(3, {0.0, 0.03, 0.0}).stripes, 0.05);
}

TEST(Demodulation, AnEdgeOfTheSampleIsNoStripe) {
  // A disc a third as bright as the rest: its edge holds every wave, the stripes' too.
  std::vector<Image<float>> pictures;
  std::vector<double> phases;
  for (int i = 0; i < 3; ++i) {
    phases.push_back(two_pi * i / 3.0);
    pictures.push_back(picture(phases.back()));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (std::hypot(x - 63.0, y - 44.0) < 33.0) pictures.back()(x, y) /= 3.0F;
      }
    }
  }
  EXPECT_LT(demodulate_phases(pictures, phases, all_used).stripes, 0.015);
  // And stripes are seen beside it.
  for (float& value : pictures[1].values()) value *= 1.06F;
  EXPECT_GT(demodulate_phases(pictures, phases, all_used).stripes, 0.03);
}

TEST(Demodulation, TwoEqualPhasesAreRefused) {
  const std::vector<Image<float>> pictures{picture(0.0), picture(0.0), picture(std::numbers::pi)};
  const std::vector<double> phases{0.0, 0.0, std::numbers::pi};
  EXPECT_NE(sentence_of([&] {
              demodulate_phases(pictures, phases, all_used);
            }).find("phases do not determine"),
            std::string::npos);
}

TEST(SinglePicture, FindsItsCarrierAndRecoversSlowStructure) {
  const Image<float> p = picture(0.7);
  const Carrier found = find_carrier(p, all_used, {1.0 / 17.5, 0.0});
  EXPECT_NEAR(found.x, carrier.x, 1e-4);
  EXPECT_NEAR(found.y, carrier.y, 1e-4);
  const Demodulated light = demodulate_single(p, {}, all_used, found);
  expect_recovered(light, 5e-3, 0);  // slopes of mean and amplitude within a window, at corners
  EXPECT_LT(light.second_harmonic, 0.01);
}

TEST(SinglePicture, EvenLightTakesTheSampleOut) {
  Image<float> even(width, height, 1), p = picture(0.2);
  // A sharp edge that halves all light.
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float albedo = x > 60 ? 0.5F : 1.0F;
      even(x, y) = albedo * static_cast<float>(mean_at(x, y));
      p(x, y) *= albedo;
    }
  }
  const Demodulated light = demodulate_single(p, even, all_used, carrier);
  for (int x = 10; x < width - 10; ++x) {
    const double expected = (x > 60 ? 0.5 : 1.0) * amplitude_at(x, 40);
    ASSERT_NEAR(light.amplitude(x, 40) / expected, 1.0, 5e-3) << x;
  }
}

TEST(SinglePicture, DeviationsAreThoseOfItsNoise) {
  const Demodulated light = demodulate_single(picture(0.7, {0.0, 0.0, 3.0}), {}, all_used, carrier);
  double square = 0.0, stated = 0.0;
  int count = 0;
  for (int y = 12; y < height - 12; y += 6) {
    for (int x = 20; x < width - 20; x += 10) {
      square += std::pow(light.amplitude(x, y) - amplitude_at(x, y), 2);
      stated += std::pow(light.amplitude_deviation(x, y), 2);
      ++count;
    }
  }
  // About 40 independent windows: the spread of a variance is 22 %.
  EXPECT_NEAR(std::sqrt(square / stated), 1.0, 0.35) << count;
}

TEST(SinglePicture, WithoutASinusoidIsRefused) {
  Image<float> flat(width, height, 1);
  for (std::size_t i = 0; i < flat.size(); ++i) {
    flat.values()[i] = static_cast<float>(100.0 + uniform(key_of({9, i})));
  }
  EXPECT_NE(sentence_of([&] { find_carrier(flat, all_used, carrier); }).find("no sinusoid"),
            std::string::npos);
}

}  // namespace
}  // namespace kappamu::calib
