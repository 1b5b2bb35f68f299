#include "inverse/optimise/absorption_scale.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kappamu::inverse {
namespace {

CoefficientPair of_mu(double mu) {
  return {{std::log(0.3)}, {std::log(mu)}};
}

TEST(AbsorptionScale, GoesAsMuAboveItsReferenceAndAsTheLogarithmBelow) {
  const AbsorptionScale scale(0.01);
  const auto w = [&](double mu) { return scale.from_fields(of_mu(mu)).log_mu[0]; };
  EXPECT_NEAR(w(2.0) / w(1.0), 2.0, 1e-3);
  EXPECT_NEAR(w(0.0101) - w(0.0099), std::log(0.0101 / 0.0099), 1e-5);
  for (const double mu : {1e-6, 0.003, 0.01, 0.2, 30.0}) {
    const CoefficientPair back = scale.to_fields(scale.from_fields(of_mu(mu)));
    EXPECT_NEAR(back.log_mu[0], std::log(mu), 1e-9) << mu;
    EXPECT_EQ(back.log_kappa, of_mu(mu).log_kappa);
  }
}

TEST(AbsorptionScale, HasTheSlopeOfItsCurve) {
  const AbsorptionScale scale(0.01);
  for (const double mu : {0.002, 0.01, 0.05}) {
    constexpr double step = 1e-4;
    const double w = scale.from_fields(of_mu(mu)).log_mu[0];
    const auto log_mu = [&](double at) { return scale.to_fields({{0.0}, {at}}).log_mu[0]; };
    const double slope = (log_mu(w + step) - log_mu(w - step)) / (2.0 * step);
    EXPECT_NEAR(scale.by_scaled(of_mu(mu), {{5.0}, {2.0}}).log_mu[0], 2.0 * slope, 1e-6) << mu;
    EXPECT_NEAR(scale.mean_slope(of_mu(mu)), slope, 1e-6) << mu;
  }
}

TEST(AbsorptionScale, IsTheLogarithmByDefault) {
  const AbsorptionScale none;
  EXPECT_EQ(none.from_fields(of_mu(0.2)), of_mu(0.2));
  EXPECT_EQ(none.to_fields(of_mu(0.2)), of_mu(0.2));
  EXPECT_EQ(none.mean_slope(of_mu(0.2)), 1.0);
}

}  // namespace
}  // namespace kappamu::inverse
