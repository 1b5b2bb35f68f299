// The iteration of few unknowns on maps whose fixed point is known.
#include "inverse/block_model/fixed_point.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kappamu::inverse {
namespace {

using Eigen::Vector2d;

/// Steps until x ← g(x) moves by less than 1e-6.
template <class Map>
int steps_to_end(const Map& g, Vector2d x, Vector2d& end) {
  FixedPoint iteration;
  for (int k = 1; k <= 40; ++k) {
    const Vector2d there = g(x);
    if ((there - x).norm() < 1e-6) {
      end = there;
      return k;
    }
    x = iteration.next(x, there);
  }
  return 1000;
}

TEST(FixedPoint, LinearMapsEndAfterAsManyStepsAsUnknownsWhetherTheyContractOrNot) {
  const Vector2d truth(0.3, -0.2);
  for (const double rate : {0.6, 0.95, -1.5}) {
    const auto g = [&](const Vector2d& x) {
      Eigen::Matrix2d m;
      m << rate, 0.1, -0.2, 0.3;
      return Vector2d(truth + m * (x - truth));
    };
    Vector2d end = Vector2d::Zero();
    EXPECT_LE(steps_to_end(g, {0.35, -0.28}, end), 5) << rate;
    EXPECT_LT((end - truth).norm(), 1e-5) << rate;
  }
}

TEST(FixedPoint, ACurvedMapEndsFasterThanItsPlainIteration) {
  const auto g = [](const Vector2d& x) {
    return Vector2d(0.8 * std::sin(x[0]) + 0.2 * x[1] + 0.1, 0.5 * std::cos(x[0]) * x[1]);
  };
  Vector2d end = Vector2d::Zero();
  const int accelerated = steps_to_end(g, {0.5, 0.5}, end);
  Vector2d x(0.5, 0.5);
  int plain = 0;
  for (; plain < 1000 && (g(x) - x).norm() >= 1e-6; ++plain) x = g(x);
  EXPECT_LT(2 * accelerated, plain);
  EXPECT_LT((g(end) - end).norm(), 1e-5);
}

TEST(FixedPoint, StaysNearWhatWasFound) {
  FixedPoint iteration;
  iteration.next(Vector2d(0.0, 0.0), Vector2d(1.0, 1.0));
  // The differences say nearly nothing of where the end is: far away, if believed.
  const Vector2d g(1.9999, 2.0);
  const Eigen::VectorXd next = iteration.next(Vector2d(1.0, 1.0), g);
  EXPECT_LE((next - g).cwiseAbs().maxCoeff(), 0.7 + 1e-12);
}

}  // namespace
}  // namespace kappamu::inverse
