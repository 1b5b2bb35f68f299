// A beam to and fro in a column: followed passage by passage, and its derivatives by laws.
#include "forward/light/beam_column.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/numbers/dot.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Values;

constexpr double rounding = 1e-14;
constexpr double reflectances[] = {0.0, 0.0170, 0.4};

Values collided(const BeamColumn& beam, std::size_t cells) {
  Values result;
  for (std::size_t k = 0; k < cells; ++k) result.push_back(beam.collided(k));
  return result;
}

TEST(BeamColumn, IsTheSumOfItsPassages) {
  for (const double reflectance : reflectances) {
    const Values x = testing::random_values(7, 0.0, 0.4, 1);
    Values expected(x.size(), 0.0);
    double power = 1.0, out[2] = {0.0, 0.0};
    for (int passage = 0; passage < 80; ++passage) {
      for (std::size_t k = 0; k < x.size(); ++k) {
        const std::size_t cell = passage % 2 == 0 ? k : x.size() - 1 - k;
        expected[cell] += power * (1.0 - std::exp(-x[cell]));
        power *= std::exp(-x[cell]);
      }
      out[passage % 2] += (1.0 - reflectance) * power;
      power *= reflectance;
    }
    BeamColumn beam(reflectance);
    beam.set(x);
    for (std::size_t k = 0; k < x.size(); ++k) {
      EXPECT_NEAR(beam.collided(k), expected[k], rounding) << k;
    }
    EXPECT_NEAR(beam.leaves_far(), out[0], rounding);
    EXPECT_NEAR(beam.leaves_near(), out[1], rounding);
  }
}

TEST(BeamColumn, LosesNothing) {
  for (const double reflectance : reflectances) {
    for (const double thickest : {1e-9, 0.3, 5.0, 1e4}) {
      const Values x = testing::random_values(11, 0.0, thickest, 2);
      BeamColumn beam(reflectance);
      beam.set(x);
      const Values taken = collided(beam, x.size());
      EXPECT_NEAR(
          std::accumulate(taken.begin(), taken.end(), 0.0) + beam.leaves_near() + beam.leaves_far(),
          1.0, 10 * rounding);
    }
  }
}

TEST(BeamColumn, EndsInAnInfiniteCell) {
  BeamColumn beam(0.4);
  beam.set(Values{0.5, std::numeric_limits<double>::infinity()});
  EXPECT_DOUBLE_EQ(beam.collided(1), std::exp(-0.5));
  EXPECT_EQ(beam.leaves_near() + beam.leaves_far(), 0.0);
}

TEST(BeamColumn, ChangesByTheirDerivativeToOrderTwo) {
  for (const double reflectance : reflectances) {
    const Values x = testing::random_values(7, 0.05, 0.4, 3),
                 d = testing::random_values(7, -1, 1, 4);
    BeamColumn beam(reflectance);
    beam.set(x);
    const Values at = collided(beam, x.size());
    Values slope(x.size());
    beam.change(d, slope);
    Values remainders;
    for (const double step : {1e-2, 1e-3}) {
      Values moved = x;
      for (std::size_t k = 0; k < x.size(); ++k) moved[k] += step * d[k];
      beam.set(moved);
      double square = 0.0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        square += std::pow(beam.collided(k) - at[k] - step * slope[k], 2);
      }
      remainders.push_back(std::sqrt(square));
    }
    EXPECT_NEAR(std::log10(remainders[0] / remainders[1]), 2.0, 0.05) << reflectance;
  }
}

TEST(BeamColumn, GradientIsTheTransposeOfTheChange) {
  for (const double reflectance : reflectances) {
    for (const double thickest : {0.4, 60.0}) {
      const Values x = testing::random_values(9, 0.0, thickest, 5);
      const Values d = testing::random_values(9, -1, 1, 6), w = testing::random_values(9, -1, 1, 7);
      BeamColumn beam(reflectance);
      beam.set(x);
      Values change(x.size()), gradient(x.size());
      beam.change(d, change);
      beam.gradient(w, gradient);
      EXPECT_NEAR(dot(w, change), dot(gradient, d), 100 * rounding) << reflectance;
    }
  }
}

}  // namespace
}  // namespace kappamu::forward
