// How near the metric of the fit comes to the Hessian that it guesses.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/numbers/dot.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/problem/problem.h"
#include "inverse/uncertainty/uncertainty.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

struct Spectrum {
  Eigen::VectorXd values;  ///< Ritz values, ascending
  Eigen::VectorXd shares;  ///< of all directions, that each stands for
};

/// By Lanczos from a random direction: its squared parts along the eigenvectors are, on average,
/// equal (stochastic quadrature, Golub & Meurant).
template <class Product>
Spectrum spectrum(const Product& product, std::size_t n, int steps) {
  cases::Noise noise(3);
  Vector v(n);
  for (double& x : v) x = noise.normal();
  const double length = std::sqrt(dot(v, v));
  for (double& x : v) x /= length;
  std::vector<Vector> basis;
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(steps, steps);
  for (int k = 0; k < steps; ++k) {
    basis.push_back(v);
    Vector w = product(v);
    t(k, k) = dot(w, v);
    for (int repeat = 0; repeat < 2; ++repeat) {
      for (const Vector& b : basis) {
        const double along = dot(b, w);
        for (std::size_t i = 0; i < n; ++i) w[i] -= along * b[i];
      }
    }
    const double next = std::sqrt(dot(w, w));
    if (k + 1 < steps) t(k, k + 1) = t(k + 1, k) = next;
    for (std::size_t i = 0; i < n; ++i) v[i] = w[i] / next;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(t);
  return {solved.eigenvalues(), solved.eigenvectors().row(0).cwiseAbs2().transpose()};
}

/// docs/theory.md, section 4: what holds a descent up.
TEST(Metric, IsTheHessiansInverseForAllButFewDirections) {
  test_cases::Block block;
  block.grid = {32, 32, 10, 0.5};
  const CoefficientPair fine = test_cases::make_truth(block.grid.refined(2), {});
  const CoefficientPair truth = test_cases::make_truth(block.grid, {});
  const SurfaceMeasurements m = test_cases::measure(block, fine);
  Objective objective(make_problem(m, 0, forward::Convention::physical, {0.001, 5e-5}), {});
  objective.refresh_correction(refine(objective.problem()), truth);
  constexpr double alpha = 270.0;  // where its fit ends
  const double thickness = 5.0;
  const LateralBlocks blocks = lateral_blocks(random_rows(objective, 2, 1), objective.space());
  const Basis basis({block.grid, 2, thickness}, {Coordinates::informed, thickness, alpha}, blocks);
  const Prior prior{alpha, 10.0 * thickness};
  const Spectrum found = spectrum(
      [&](const Vector& z) {
        return basis.gradient(hessian_product(objective, prior, basis.to_fields(z)));
      },
      2 * block.grid.cells(), 60);
  const auto within = [&](double low, double high) {
    double share = 0.0;
    for (Eigen::Index k = 0; k < found.values.size(); ++k) {
      if (found.values[k] > low && found.values[k] < high) share += found.shares[k];
    }
    return share;
  };
  std::printf(
      "eigenvalues of BᵀHB: %.2g to %.2g, %.1f %% within 0.7 to 1.4, %.1f %% within 0.5 to 2\n",
      found.values[0], found.values[found.values.size() - 1], 100.0 * within(0.7, 1.4),
      100.0 * within(0.5, 2.0));
  EXPECT_GT(within(0.7, 1.4), 0.9);
  EXPECT_GT(within(0.5, 2.0), 0.95);
  EXPECT_GT(found.values[0], 0.0);
}

/// Where the data's squares fall by a third of an e-fold from band to band, and neighbouring depths
/// go together, two rows tell the longest waves' squares and correlations.
TEST(Metric, TellsTheLongestWavesFromTheirOwnBandsAndCorrelationsFromMany) {
  const GridShape grid{40, 40, 20, 0.5};
  const LateralModes modes({grid});
  constexpr double together = 0.6;
  const auto square = [](int bin) { return std::exp(-bin / 3.0); };
  double squares = 0.0;
  double correlation = 0.0;
  constexpr int trials = 20;
  cases::Noise noise(4);
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<CoefficientPair> rows;
    for (int probe = 0; probe < 2; ++probe) {
      Eigen::MatrixXd waves(modes.rows(), 40 * 40);
      for (int bin = 0; bin < modes.bins(); ++bin) {
        for (const int wave : modes.members(bin)) {
          double before = noise.normal();
          for (int row = 0; row < modes.rows(); ++row) {
            before = together * before + std::sqrt(1.0 - together * together) * noise.normal();
            waves(row, wave) = std::sqrt(square(bin)) * before;
          }
        }
      }
      rows.push_back(modes.synthesise(waves));
    }
    const Eigen::MatrixXd longest = lateral_blocks(rows, {grid}, 0.0).front();
    squares += longest.trace() / modes.rows() / trials;
    for (int row = 0; row + 1 < modes.rows(); ++row) {
      correlation += longest(row, row + 1) /
                     std::sqrt(longest(row, row) * longest(row + 1, row + 1)) /
                     (trials * (modes.rows() - 1.0));
    }
  }
  EXPECT_NEAR(squares, 0.75, 0.15) << "all bands that make the matrix regular have 0.4 on average";
  EXPECT_NEAR(correlation, together, 0.1);
}

}  // namespace
}  // namespace kappamu::inverse
