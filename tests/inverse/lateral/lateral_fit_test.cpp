// Coefficients from exact and noisy reflectances of known media.
#include "inverse/lateral/lateral_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kappamu::inverse {
namespace {

PerFrequency vector_of(std::initializer_list<double> values) {
  PerFrequency v(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) v[i++] = value;
  return v;
}

PerFrequency reflectance(const forward::LateralReflectance& model, const PerFrequency& f,
                         double mua, double musp) {
  PerFrequency r(f.size());
  for (Eigen::Index i = 0; i < f.size(); ++i) r[i] = model(f[i], mua, musp).reflectance;
  return r;
}

const PerFrequency two = vector_of({0.0, 0.2}), three = vector_of({0.0, 0.1, 0.3});
constexpr double noise = 0.01;

TEST(LateralFit, RecoversMediaFromAnyStart) {
  const forward::LateralReflectance model({1.4, 0.9, {}});
  for (const auto& f : {two, three}) {
    for (const double mua : {0.002, 0.03, 0.2}) {
      for (const double musp : {0.4, 1.1, 3.0}) {
        const PerFrequency deviation = PerFrequency::Constant(f.size(), noise);
        const LateralFit fit =
            fit_lateral(model, f, reflectance(model, f, mua, musp), deviation, {});
        ASSERT_EQ(fit.verdict, LateralVerdict::good) << mua << " " << musp;
        EXPECT_NEAR(fit.coefficients.mua / mua, 1.0, 1e-5);
        EXPECT_NEAR(fit.coefficients.musp / musp, 1.0, 1e-5);
      }
    }
  }
}

TEST(LateralFit, GainIsTheChangeOfTheAnswer) {
  const forward::LateralReflectance model({1.4, 0.9, 6.0});
  const PerFrequency r = reflectance(model, three, 0.02, 1.0);
  const PerFrequency deviation = PerFrequency::Constant(3, noise);
  const LateralFit fit = fit_lateral(model, three, r, deviation, {});
  for (Eigen::Index i = 0; i < 3; ++i) {
    PerFrequency moved = r;
    moved[i] *= 1.001;
    const LateralFit other = fit_lateral(model, three, moved, deviation, {});
    EXPECT_NEAR(std::log(other.coefficients.mua / fit.coefficients.mua), 0.001 * fit.gain(0, i),
                2e-5);
    EXPECT_NEAR(std::log(other.coefficients.musp / fit.coefficients.musp), 0.001 * fit.gain(1, i),
                2e-5);
  }
}

TEST(LateralFit, SaysWhyAPixelHasNoCoefficients) {
  const forward::LateralReflectance model({1.4, 0.9, {}});
  const PerFrequency deviation = PerFrequency::Constant(2, noise);
  const auto verdict = [&](double even, double wave) {
    return fit_lateral(model, two, vector_of({even, wave}), deviation, {}).verdict;
  };
  EXPECT_EQ(verdict(0.0, 0.1), LateralVerdict::no_light);
  EXPECT_EQ(verdict(1.3, 0.2), LateralVerdict::no_medium);   // glare: more light than entered
  EXPECT_EQ(verdict(0.3, 0.35), LateralVerdict::no_medium);  // amplitude above the mean
}

}  // namespace
}  // namespace kappamu::inverse
