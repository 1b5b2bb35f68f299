// Response recovery in simulation. Real photographs: real_bracket_test.cpp.
#include "capture/response/response.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/response/radiometry.h"
#include "core/error.h"
#include "tests/capture/session_files.h"
#include "tests/capture/simulated_camera.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

// Relative errors of the curve in percent over codes a merge uses (2 % of the range above black to
// saturation), after the best common factor: a factor cancels against the white target.
struct CurveError {
  double median_percent = 0.0;
  double worst_percent = 0.0;
  double factor_percent = 0.0;  // of the full scale itself
};

CurveError curve_error(const SimulatedCamera& camera, const std::vector<double>& linear) {
  std::vector<double> logarithms;
  const int from = static_cast<int>(camera.black_code + 0.02 * (camera.top() - camera.black_code));
  for (int code = from; code < saturation_code(camera.bit_depth); ++code) {
    double low = 0.0;
    double high = 1.0;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (low + high);
      (camera.code_of(middle) < code ? low : high) = middle;
    }
    logarithms.push_back(std::log(linear[static_cast<std::size_t>(code)] / low));
  }
  const auto median = [](std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  const double factor = median(logarithms);
  CurveError error;
  error.factor_percent = 100.0 * std::abs(factor);
  for (double& value : logarithms) {
    value = 100.0 * std::abs(value - factor);
    error.worst_percent = std::max(error.worst_percent, value);
  }
  error.median_percent = median(logarithms);
  return error;
}

RecoveredResponse recover(const SimulatedCamera& camera, unsigned seed) {
  const Image<float> scene = smooth_scene(320, 240, 1, 0.003, 20.0);
  const std::vector<ExposedFrame> stack = shoot_stack(camera, scene, seven_exposures(), seed);
  std::vector<ResponseSample> samples;
  collect_response_samples(stack, 0, camera.bit_depth, samples);
  return recover_response(samples, camera.bit_depth, camera.black_code, "simulated");
}

struct Case {
  const char* name;
  double (*curve)(double);
  int bit_depth;
  double black_code;
  double median_percent;  // bounds, about twice what was measured when written
  double worst_percent;
};

// A logarithm with an S on top, of another shape than any the fit's base knows.
double film_curve(double signal) {
  return 0.85 * std::log1p(8.0 * signal) / std::log1p(8.0) +
         0.15 * signal * signal * (3.0 - 2.0 * signal);
}

class ResponseRecovery : public testing::TestWithParam<Case> {};

TEST_P(ResponseRecovery, FindsTheCurve) {
  const Case& wanted = GetParam();
  SimulatedCamera camera{wanted.bit_depth, wanted.black_code, 20000.0, 5.0, wanted.curve};
  const RecoveredResponse recovered = recover(camera, 7);
  const CurveError error = curve_error(camera, recovered.linear);
  std::printf("%-20s median %.3f %% worst %.2f %% factor %.2f %% residual %.4f pooled %d\n",
              wanted.name, error.median_percent, error.worst_percent, error.factor_percent,
              recovered.report.residual_rms, recovered.report.pooled_codes);
  EXPECT_LT(error.median_percent, wanted.median_percent);
  EXPECT_LT(error.worst_percent, wanted.worst_percent);
  EXPECT_LT(error.factor_percent, 2.0);
}

INSTANTIATE_TEST_SUITE_P(Curves, ResponseRecovery,
                         testing::Values(Case{"Srgb12Bit", srgb_curve, 12, 40.0, 0.3, 2.0},
                                         Case{"Shoulder12Bit", shoulder_curve, 12, 64.0, 0.3, 2.0},
                                         Case{"Film12Bit", film_curve, 12, 49.14, 0.3, 2.0},
                                         Case{"Straight12Bit", straight_curve, 12, 40.0, 0.3, 2.0},
                                         Case{"Srgb16Bit", srgb_curve, 16, 900.0, 0.3, 2.0},
                                         Case{"Srgb8Bit", srgb_curve, 8, 6.0, 0.5, 4.0},
                                         Case{"Shoulder8Bit", shoulder_curve, 8, 4.0, 0.5, 4.0}),
                         [](const auto& instance) { return instance.param.name; });

TEST(ResponseCurve, RisesFromZeroAtBlackToOneAtTheLargestCode) {
  const SimulatedCamera camera{10, 33.25, 8000.0, 12.0, srgb_curve};
  const std::vector<double> linear = recover(camera, 3).linear;
  ASSERT_EQ(linear.size(), 1024U);
  EXPECT_EQ(linear.back(), 1.0);
  EXPECT_LT(linear[33], 0.0);
  EXPECT_GT(linear[34], 0.0);
  for (std::size_t code = 1; code < linear.size(); ++code) {
    ASSERT_GT(linear[code], linear[code - 1]) << code;
  }
}

// A curve that flattens ever faster: a smoothness that cuts its last bend shows in the full scale.
TEST(ResponseCurve, AShoulderKeepsItsEnd) {
  const SimulatedCamera camera{12, 49.14, 20000.0, 5.0, film_curve};
  for (const unsigned seed : {7U, 8U}) {
    EXPECT_LT(curve_error(camera, recover(camera, seed).linear).factor_percent, 0.5) << seed;
  }
}

TEST(ResponseCurve, EqualInputGivesEqualBits) {
  const SimulatedCamera camera{12, 40.0, 20000.0, 5.0, srgb_curve};
  EXPECT_EQ(recover(camera, 11).linear, recover(camera, 11).linear);
}

// A tenth of the scene moves between exposures.
TEST(ResponseCurve, IsNotBentByWhatMoves) {
  const SimulatedCamera camera{12, 40.0, 20000.0, 5.0, srgb_curve};
  const Image<float> scene = smooth_scene(320, 240, 1, 0.003, 20.0);
  std::vector<ExposedFrame> stack = shoot_stack(camera, scene, seven_exposures(), 5);
  for (std::size_t j = 0; j < stack.size(); j += 2) {
    for (int y = 100; y < 124; ++y) {
      for (int x = 0; x < 320; ++x) {
        auto& code = stack[j].pixels(x, y);
        code = static_cast<std::uint16_t>(std::min(4095, code + 300));
      }
    }
  }
  std::vector<ResponseSample> samples;
  collect_response_samples(stack, 0, 12, samples);
  const RecoveredResponse recovered = recover_response(samples, 12, 40.0, "simulated");
  EXPECT_GT(recovered.report.outlier_share, 0.01);
  EXPECT_LT(curve_error(camera, recovered.linear).median_percent, 0.5);
}

TEST(ResponseCurve, OneExposureIsNotEnoughAndSaysSo) {
  const SimulatedCamera camera{12, 40.0, 20000.0, 5.0, srgb_curve};
  const Image<float> scene = smooth_scene(64, 64, 1, 0.003, 20.0);
  std::vector<ResponseSample> samples;
  collect_response_samples(shoot_stack(camera, scene, {0.1}, 5), 0, 12, samples);
  EXPECT_THAT(sentence_of([&] { recover_response(samples, 12, 40.0, "s/session.json"); }),
              testing::AllOf(testing::StartsWith("s/session.json: the exposure stacks do not hold"),
                             testing::HasSubstr("add exposure times")));
}

TEST(LinearResponse, IsStraightThroughBlackAndFullScale) {
  const std::vector<double> linear = linear_response(8, 10.5);
  EXPECT_EQ(linear.back(), 1.0);
  EXPECT_NEAR(linear[10], -0.5 / 244.5, 1e-15);
  EXPECT_NEAR(linear[11], 0.5 / 244.5, 1e-15);
}

}  // namespace
}  // namespace kappamu::capture
