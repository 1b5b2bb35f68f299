#include "core/numbers/elementary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace kappamu {
namespace {

/// Near zero, near the ends of the reduced ranges, and far out.
std::vector<double> places() {
  std::vector<double> x{0.0, 1e-300, -1e-300, 1e-9, -1e-9, 0.34657359, 0.34657360, 700.0, -700.0};
  for (int k = -4000; k <= 4000; ++k) x.push_back(0.0123 * k);
  return x;
}

TEST(Elementary, ExponentialsAreThoseOfTheLibrary) {
  std::vector<double> found = places();
  exponentiate(found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double expected = std::exp(places()[i]);
    ASSERT_NEAR(found[i], expected, 5e-16 * expected) << places()[i];
  }
}

TEST(Elementary, ArsinhIsThatOfTheLibrary) {
  std::vector<double> found = places();
  take_arsinh(found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double expected = std::asinh(places()[i]);
    ASSERT_NEAR(found[i], expected, 1e-15 * std::max(1.0, std::abs(expected))) << places()[i];
  }
}

TEST(Elementary, WhatIsNoNumberStaysNone) {
  std::vector<double> x(3, std::numeric_limits<double>::quiet_NaN()), y = x;
  exponentiate(x);
  take_arsinh(y);
  EXPECT_TRUE(std::isnan(x[1]) && std::isnan(y[1]));
}

}  // namespace
}  // namespace kappamu
