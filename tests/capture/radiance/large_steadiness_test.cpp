// Frames of many megapixels, which are compared on a lattice of blocks: what does not fit is found
// there as well, and where it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/radiance/steadiness.h"
#include "tests/capture/simulated_camera.h"

namespace kappamu::capture {
namespace {

constexpr int width = 4800, height = 3200;
const std::vector<double> times{1.0 / 30.0, 0.2, 1.2};
const std::vector<std::string> files{"f0.png", "f1.png", "f2.png"};

/// A lit patch in a dark ground with texture of two sizes, `shift` px along x.
Image<float> scene(double shift = 0.0) {
  const double middle = 0.45 * width + shift;
  Image<float> radiance(width, height, 1);
  std::vector<double> along(width), fine(width);
  for (int x = 0; x < width; ++x) {
    along[static_cast<std::size_t>(x)] = std::exp(-0.5 * std::pow((x - middle) / 900.0, 2));
    fine[static_cast<std::size_t>(x)] =
        0.1 * std::sin(0.19 * (x - shift)) + 0.1 * std::sin(0.011 * (x - shift));
  }
  for (int y = 0; y < height; ++y) {
    const double down = std::exp(-0.5 * std::pow((y - 0.55 * height) / 700.0, 2));
    for (int x = 0; x < width; ++x) {
      const auto k = static_cast<std::size_t>(x);
      radiance(x, y) = static_cast<float>((0.004 + 1.5 * along[k] * down) *
                                          (1.0 + fine[k] * std::sin(0.17 * y)));
    }
  }
  return radiance;
}

ExposedFrame shot(const Image<float>& radiance, std::size_t frame) {
  const SimulatedCamera camera{12, 40.0, 20000.0, 5.0, straight_curve};
  return shoot_stack(camera, radiance, {times[frame]}, 40 + static_cast<unsigned>(frame))[0];
}

std::vector<Fault> faults_of(const std::vector<ExposedFrame>& stack, Steadiness* states) {
  Radiometry radiometry;
  radiometry.bit_depth = 12;
  radiometry.black_level = {40.0};
  radiometry.response.linear = {linear_response(12, 40.0)};
  radiometry.noise = {{20000.0, 5.0, false}};
  *states = compare_frames(stack, radiometry);
  return find_faults(*states, times, files, {});
}

TEST(LargeSteadiness, FaultsAreFoundAsInSmallPictures) {
  const Image<float> still = scene();
  std::vector<ExposedFrame> stack;
  for (std::size_t j = 0; j < times.size(); ++j) stack.push_back(shot(still, j));
  Steadiness states;
  EXPECT_TRUE(faults_of(stack, &states).empty());
  for (const auto& state : states) {
    ASSERT_TRUE(state);
    EXPECT_LT(state->log_gain_sigma, 0.0005);  // a tenth of the tolerance
    EXPECT_LT(state->shift_sigma_px, 0.01);
  }

  const ExposedFrame steady = stack[2];
  Image<float> brighter = still;
  for (float& value : brighter.values()) value *= 1.008F;
  stack[2] = shot(brighter, 2);
  std::vector<Fault> faults = faults_of(stack, &states);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Fault::Kind::flicker);
  EXPECT_EQ(faults[0].frame, 2U);
  EXPECT_NEAR(states[2]->log_gain, std::log(1.008), 0.001);

  for (const double shift : {0.2, 9.0}) {
    stack[2] = shot(scene(shift), 2);
    faults = faults_of(stack, &states);
    ASSERT_EQ(faults.size(), 1U) << shift;
    EXPECT_EQ(faults[0].kind, Fault::Kind::moved);
    EXPECT_EQ(faults[0].frame, 2U);
    // Of the shift by 9 px the last one is found by the equations, as good as its tolerance.
    EXPECT_NEAR(states[2]->shift_px[0], shift, shift < 1.0 ? 0.03 : SteadyTolerance{}.shift_px);
  }

  // A hand that hides part of what is lit.
  stack[2] = steady;
  Image<std::uint16_t>& pixels = stack[2].pixels;
  for (int y = 1500; y < 2100; ++y) std::fill_n(&pixels(2600, y), 1200, std::uint16_t{60});
  faults = faults_of(stack, &states);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Fault::Kind::changed);
  EXPECT_EQ(faults[0].frame, 2U);
}

}  // namespace
}  // namespace kappamu::capture
