// The sensor obeys its own noise model. Recovery of the response is tested in tests/capture.
#include "data_synthetic/rig/sensor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data_synthetic/scene/random.h"

namespace kappamu::synthetic {
namespace {

struct Moments {
  double mean = 0.0;
  double variance = 0.0;
};

Moments moments(const Image<std::uint16_t>& image, int channel) {
  double sum = 0.0;
  double squares = 0.0;
  const double count = static_cast<double>(image.width()) * image.height();
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += image(x, y, channel);
      squares += static_cast<double>(image(x, y, channel)) * image(x, y, channel);
    }
  }
  const double mean = sum / count;
  return {mean, squares / count - mean * mean};
}

Image<float> even_image(float value) {
  return Image<float>(97, 101, 3, value);
}

TEST(Sensor, ResponseRisesSmoothlyFromZeroToOne) {
  for (const double strength : {7.0, 8.0, 9.0}) {
    EXPECT_DOUBLE_EQ(response(0.0, strength), 0.0);
    EXPECT_NEAR(response(1.0, strength), 1.0, 1e-15);
    double previous_slope = 0.0;
    for (int i = -50; i < 1000; ++i) {
      const double slope =
          1000.0 * (response((i + 1) / 1000.0, strength) - response(i / 1000.0, strength));
      EXPECT_GT(slope, 0.0) << "at " << i;
      // Second derivative below k²: no kink, zero included.
      if (i > -50) {
        EXPECT_LT(std::abs(slope - previous_slope), strength * strength / 1000.0);
      }
      previous_slope = slope;
    }
  }
}

TEST(Sensor, NoiseHasTheStatedMeanAndVariance) {
  SensorModel sensor;
  sensor.encoding = capture::Encoding::linear;
  sensor.bit_depth = 16;
  const double scale = (1.0 - sensor.black_level) * 65535.0;
  for (const double noise_scale : {1.0, 3.0}) {
    sensor.noise_scale = noise_scale;
    for (const float level : {0.001F, 0.01F, 0.6F}) {
      const Moments found = moments(expose(sensor, even_image(level), 0.5, 7), 1);
      const double signal = 0.5 * level;
      const double electrons = sensor.effective_electrons();
      const double deviation =
          std::sqrt(signal * electrons + std::pow(sensor.effective_read_noise(), 2)) / electrons *
          scale;
      const double count = 97.0 * 101.0;
      const double five_errors_of_mean = 5.0 * deviation / std::sqrt(count);
      EXPECT_NEAR(found.mean, sensor.black_level * 65535.0 + signal * scale, five_errors_of_mean);
      // Standard error of a variance, normal and Poisson kurtosis: √((2 + 1/λ)/n).
      const double five_errors_of_variance =
          5.0 * std::sqrt((2.0 + 1.0 / (signal * electrons)) / count);
      EXPECT_NEAR(found.variance / (deviation * deviation + 1.0 / 12.0), 1.0,
                  five_errors_of_variance);
    }
  }
}

TEST(Sensor, DarkFrameSitsAtTheBlackLevelUnclipped) {
  SensorModel sensor;
  const Image<std::uint16_t> dark = expose(sensor, even_image(0.0F), 8.0, 1);
  const Moments found = moments(dark, 0);
  // Below zero the response goes on straight, so that read noise stays symmetric; above it bends
  // by a part of a code.
  constexpr double bend_codes = 0.1;
  EXPECT_NEAR(found.mean, sensor.black_level * 4095.0, bend_codes);
  for (const std::uint16_t code : dark.values()) EXPECT_GT(code, 0);
}

TEST(Sensor, SaturatesAtTheLargestCode) {
  for (const int bits : {8, 12, 16}) {
    SensorModel sensor;
    sensor.bit_depth = bits;
    const Image<std::uint16_t> codes = expose(sensor, even_image(3.0F), 1.0, 1);
    for (const std::uint16_t code : codes.values()) EXPECT_EQ(code, (1 << bits) - 1);
  }
}

TEST(Sensor, NoiseOffLeavesTheRoundedModel) {
  SensorModel sensor;
  sensor.noise_scale = 0.0;
  Image<float> ramp(50, 3, 3);
  for (int x = 0; x < 50; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int c = 0; c < 3; ++c) ramp(x, y, c) = static_cast<float>(x) / 49.0F;
    }
  }
  const Image<std::uint16_t> codes = expose(sensor, ramp, 0.5, 3);
  for (int x = 0; x < 50; ++x) {
    for (int c = 0; c < 3; ++c) {
      const double ideal = encode(sensor, 0.5 * ramp(x, 1, c), c) * 4095.0;
      EXPECT_NEAR(codes(x, 1, c), ideal, 0.5 + 1e-6);
    }
  }
}

// Eight values at a time as one by one, all branches: dark, few and many electrons, saturated.
TEST(Sensor, CodesAreThoseOfTheModelOneByOne) {
  for (const auto encoding : {capture::Encoding::linear, capture::Encoding::response}) {
    for (const float top : {1.3F, 0.002F}) {
      SensorModel sensor;
      sensor.encoding = encoding;
      sensor.bit_depth = 16;
      Image<float> ramp(101, 53, 3);
      for (std::size_t i = 0; i < ramp.size(); ++i) {
        ramp.values()[i] = top * static_cast<float>(i) / static_cast<float>(ramp.size());
      }
      const double exposure_s = 0.9;
      const std::uint64_t frame_key = key_of({sensor.seed, 0xF4A3E, 5});
      const Image<std::uint16_t> codes = expose(sensor, ramp, exposure_s, 5);
      int other = 0;
      for (std::size_t i = 0; i < ramp.size(); ++i) {
        double signal = static_cast<double>(ramp.values()[i]) * exposure_s;
        const double read = sensor.read_noise_electrons / sensor.electrons_full_scale;
        const double spread = std::sqrt(signal / sensor.electrons_full_scale + read * read);
        if (signal < 1.0 + 10.0 * spread) {
          const std::uint64_t key = mix(frame_key ^ i);
          const NormalPair normal = normal_pair(key);
          signal = (poisson(signal * sensor.electrons_full_scale, key, normal.first) +
                    sensor.read_noise_electrons * normal.second) /
                   sensor.electrons_full_scale;
        }
        const double code = std::clamp(
            std::round(65535.0 * encode(sensor, signal, static_cast<int>(i % 3))), 0.0, 65535.0);
        other += codes.values()[i] == code ? 0 : 1;
        ASSERT_NEAR(codes.values()[i], code, 1.0) << i;  // where the rounding is a matter of bits
      }
      EXPECT_LT(other, 3);
    }
  }
}

TEST(Sensor, GivesTheSameBitsOnAnyNumberOfThreadsAndOtherNoiseInEachFrame) {
  SensorModel sensor;
  const Image<float> even = even_image(0.4F);
  const auto frame = expose(sensor, even, 1.0, 11, 1).values();
  EXPECT_EQ(frame, expose(sensor, even, 1.0, 11, 5).values());
  EXPECT_NE(frame, expose(sensor, even, 1.0, 12, 5).values());
  sensor.seed = 2;
  EXPECT_NE(frame, expose(sensor, even, 1.0, 11, 5).values());
}

TEST(Sensor, NoiseOfNeighboursAndChannelsIsIndependent) {
  SensorModel sensor;
  sensor.encoding = capture::Encoding::linear;
  const Image<std::uint16_t> codes = expose(sensor, even_image(0.4F), 1.0, 2);
  const Moments whole = moments(codes, 0);
  double beside = 0.0;
  double across = 0.0;
  const double mean_1 = moments(codes, 1).mean;
  for (int y = 0; y < codes.height(); ++y) {
    for (int x = 0; x + 1 < codes.width(); ++x) {
      beside += (codes(x, y, 0) - whole.mean) * (codes(x + 1, y, 0) - whole.mean);
      across += (codes(x, y, 0) - whole.mean) * (codes(x, y, 1) - mean_1);
    }
  }
  const double pairs = (codes.width() - 1.0) * codes.height();
  const double five_errors = 5.0 / std::sqrt(pairs);
  EXPECT_LT(std::abs(beside / pairs / whole.variance), five_errors);
  EXPECT_LT(std::abs(across / pairs / whole.variance), five_errors);
}

TEST(Random, PoissonHasEqualMeanAndVarianceOnBothBranches) {
  for (const double mean : {0.3, 5.0, 63.0, 65.0, 900.0}) {
    constexpr int count = 40000;
    double sum = 0.0;
    double squares = 0.0;
    for (int i = 0; i < count; ++i) {
      const std::uint64_t key = key_of({99, static_cast<std::uint64_t>(i)});
      const double value = poisson(mean, key, normal_pair(key).first);
      sum += value;
      squares += value * value;
    }
    const double found = sum / count;
    EXPECT_NEAR(found, mean, 5.0 * std::sqrt(mean / count));
    const double five_errors = 5.0 * std::sqrt((2.0 + 1.0 / mean) / count);
    EXPECT_NEAR((squares / count - found * found) / mean, 1.0, five_errors);
  }
}

}  // namespace
}  // namespace kappamu::synthetic
