// When the host looks at a device's iteration.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "forward/linear/conjugate_gradients.h"

namespace kappamu::forward::linear {
namespace {

struct Course {
  int end = 0;    ///< the first iteration that is enough
  int found = 0;  ///< the one that is looked at and is enough
  int looks = 0;
};

/// A course of excess(iteration), at most so many iterations long.
template <class Excess>
Course course(const Excess& excess, int most = 400) {
  Course result;
  while (result.end < most && excess(result.end) > 1.0) ++result.end;
  Looks looks;
  for (result.found = 0; result.found < most; ++result.found) {
    if (!looks.due(result.found)) continue;
    ++result.looks;
    const double now = excess(result.found);
    if (now <= 1.0) break;
    looks.saw(result.found, now);
  }
  return result;
}

/// Falls by equal factors: no iteration is made in vain, and far fewer looks than iterations.
TEST(Looks, AnEvenFallIsFollowedToItsEnd) {
  for (const double factor : {1.3, 2.0, 5.0, 30.0, 1000.0}) {
    for (const double first : {1.0, 3.0, 1e4, 1e8, 1e12}) {
      const Course c = course([&](int iteration) { return first / std::pow(factor, iteration); });
      EXPECT_EQ(c.found, c.end) << factor << ' ' << first;
      EXPECT_LE(c.looks, 8 + c.end / 3) << factor << ' ' << first;
    }
  }
}

/// One that becomes a quarter faster after each look is found at its end, too.
TEST(Looks, AFallThatQuickensIsNotMissed) {
  for (const double factor : {1.5, 3.0, 10.0}) {
    const Course c = course([&](int iteration) {
      const double slow = std::min(iteration, 10);
      return 1e8 * std::pow(factor, -slow - 1.25 * (iteration - slow));
    });
    EXPECT_EQ(c.found, c.end) << factor;
  }
}

/// Without a fall, and with what is no number, every iteration or every eighth is looked at.
TEST(Looks, NothingIsLostWhereNothingFalls) {
  EXPECT_LE(course([](int iteration) { return iteration < 50 ? 7.0 : 0.5; }).found, 50);
  EXPECT_LE(course([](int iteration) { return iteration < 5 ? HUGE_VAL : 0.5; }).found, 5);
  EXPECT_LE(course([](int iteration) {
              return iteration < 9 ? std::numeric_limits<double>::quiet_NaN() : 0.5;
            }).found,
            9);
  const Course c = course([](int iteration) {
    return iteration < 5 ? 100.0 / (1 + iteration) : iteration < 60 ? 20.0 : 0.5;
  });
  EXPECT_LE(c.found - c.end, 7);
}

}  // namespace
}  // namespace kappamu::forward::linear
