#include "inverse/lateral/spectral_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "forward/lateral/chromophores.h"

namespace kappamu::inverse {
namespace {

const std::vector<double> wavelengths{530.0, 590.0, 660.0, 730.0, 850.0, 970.0};

Eigen::MatrixXd spectra(const std::vector<Chromophore>& absorbers) {
  Eigen::MatrixXd all(wavelengths.size(), absorbers.size());
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    for (Eigen::Index j = 0; j < all.cols(); ++j) {
      all(i, j) = chromophore_absorption(absorbers[static_cast<std::size_t>(j)],
                                         wavelengths[static_cast<std::size_t>(i)]);
    }
  }
  return all;
}

TEST(SpectralFit, AmountsOfExactDataAreExact) {
  const Eigen::MatrixXd s =
      spectra({Chromophore::hbo2, Chromophore::hb, Chromophore::water, Chromophore::fat});
  const Eigen::Vector4d truth(60.0, 25.0, 0.7, 0.15);
  const Eigen::VectorXd mua = s * truth;
  const AmountFit fit = fit_amounts(s, mua, 0.02 * mua);
  for (Eigen::Index j = 0; j < 4; ++j) EXPECT_NEAR(fit.amount[j] / truth[j], 1.0, 1e-6);
  EXPECT_LT(fit.chi_square, 1e-12);
}

TEST(SpectralFit, DeviationsHoldTheErrors) {
  const Eigen::MatrixXd s = spectra({Chromophore::hbo2, Chromophore::hb, Chromophore::water});
  const Eigen::Vector3d truth(60.0, 25.0, 0.7);
  std::mt19937_64 random(20413);
  std::normal_distribution<double> normal;
  int inside = 0, trials = 600;
  double chi_square = 0.0;
  for (int t = 0; t < trials; ++t) {
    const Eigen::VectorXd deviation = 0.01 * (s * truth);
    Eigen::VectorXd mua = s * truth;
    for (double& one : mua) one *= 1.0 + 0.01 * normal(random);
    const AmountFit fit = fit_amounts(s, mua, deviation);
    chi_square += fit.chi_square / (3.0 * trials);
    for (Eigen::Index j = 0; j < 3; ++j) {
      if (std::abs(fit.amount[j] - truth[j]) < 2.0 * fit.deviation(j)) ++inside;
    }
  }
  // 95.4 % of 1800, six standard deviations wide.
  EXPECT_NEAR(inside / (3.0 * trials), 0.954, 0.03);
  EXPECT_NEAR(chi_square, 1.0, 0.15);
}

TEST(SpectralFit, AnAbsorberThatIsNotThereIsZeroAndTheRestIsTheMinimum) {
  const Eigen::MatrixXd s = spectra({Chromophore::hbo2, Chromophore::hb, Chromophore::water});
  const Eigen::Vector3d without(40.0, -3.0, 0.5);
  const Eigen::VectorXd mua = s * without, deviation = 0.01 * mua;
  const AmountFit fit = fit_amounts(s, mua, deviation);
  EXPECT_DOUBLE_EQ(fit.amount[1], 0.0);
  // No other non-negative point is better (the problem is convex: neighbours suffice).
  for (Eigen::Index j = 0; j < 3; ++j) {
    for (const double step : {-1e-3, 1e-3}) {
      Eigen::VectorXd other = fit.amount;
      other[j] += step;
      if (other[j] < 0.0) continue;
      EXPECT_GE((mua - s * other).cwiseQuotient(deviation).squaredNorm(),
                fit.chi_square * (1.0 - 1e-9));
    }
  }
}

TEST(SpectralFit, AlikeSpectraAreNotDistinct) {
  Eigen::MatrixXd s = spectra({Chromophore::hbo2, Chromophore::hb});
  EXPECT_TRUE(distinct(s));
  s.col(1) = 3.0 * s.col(0);
  EXPECT_FALSE(distinct(s));
  EXPECT_FALSE(distinct(s.topRows(1)));
}

TEST(SpectralFit, ScatteringLawIsRecovered) {
  Eigen::VectorXd nm(4), musp(4);
  nm << 450.0, 560.0, 700.0, 900.0;
  for (Eigen::Index i = 0; i < 4; ++i) musp[i] = 1.8 * std::pow(nm[i] / 500.0, -1.3);
  const ScatteringLaw law = fit_scattering_law(nm, musp, 0.02 * musp);
  EXPECT_NEAR(law.at_500nm, 1.8, 1e-9);
  EXPECT_NEAR(law.exponent, 1.3, 1e-9);
  EXPECT_GT(law.exponent_deviation, 0.0);
}

}  // namespace
}  // namespace kappamu::inverse
