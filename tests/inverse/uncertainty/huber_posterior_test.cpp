// Huber-TV as a prior: the Gaussian that stands for it at a fitted volume (lagged diffusivity)
// against dense matrices, and its standard deviations against those of the posterior itself, drawn
// by Hamiltonian Monte Carlo (Neal 2011).
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <vector>

#include "inverse/fit/fit_function.h"
#include "inverse/uncertainty/uncertainty.h"
#include "tests/inverse/inverse_cases.h"
#include "tests/inverse/joined.h"

namespace kappamu::inverse {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A block of 6 × 4 × 3 voxels whose κ jumps by a factor of four half-way, under six patterns, at
/// the minimum of ½ χ² + α R.
class HuberPosterior : public ::testing::Test {
 protected:
  static constexpr GridShape shape{6, 4, 3, 0.5};
  static constexpr int axis = 2;
  static constexpr double thickness = 1.5;
  static constexpr double weight = 60.0;
  Regulariser regulariser{RegulariserKind::huber_tv, 1.0, 1.0};
  const Anchor anchor{std::log(0.2), std::log(0.02), 15.0};

  void SetUp() override {
    cases::Noise noise(11);
    Problem problem = cases::randomly_lit(shape, 6, noise);
    CoefficientPair truth{Vector(shape.cells()), Vector(shape.cells(), std::log(0.02))};
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      truth.log_kappa[i] = std::log(i % 6 < 3 ? 0.1 : 0.4);
    }
    problem.data = cases::simulate(problem.setup, truth, problem.seen_face, problem.irradiance, 6,
                                   "reference");
    for (double& d : problem.data) {
      problem.weight.push_back(std::pow(0.01 * d, -2));
      d *= 1.0 + 0.01 * noise.normal();
    }
    objective_ = std::make_unique<Objective>(
        problem,
        Backend{"reference", forward::Precision::double_precision, {1e-12, 2000}, 16, 64.0});
  }

  void minimise() {
    const CoefficientPair start{Vector(shape.cells(), anchor.log_kappa),
                                Vector(shape.cells(), anchor.log_mu)};
    const Basis basis(shape, {Coordinates::smooth, axis, thickness, thickness, weight}, {});
    FitFunction function(*objective_, basis, thickness, anchor, weight, regulariser, start);
    OptimiserState state;
    state.z = basis.from_fields(start);
    inverse::start(function, state);
    const double slope = norm(state.gradient);
    int steps = 0;
    while (norm(state.gradient) > 1e-5 * slope && steps < 500) {
      if (step(function, state, {}) == StepOutcome::stalled) break;
      ++steps;
    }
    fitted_ = basis.to_fields(state.z);
  }
  static double norm(const Vector& v) {
    return Eigen::Map<const VectorXd>(v.data(), static_cast<Index>(v.size())).norm();
  }
  Roughness rough(const CoefficientPair& fields) const {
    return roughness(shape, thickness, fields, anchor, regulariser);
  }
  Prior prior() const { return {weight, thickness, anchor.length_mm, rough(fitted_).diffusivity}; }
  MatrixXd dense(const std::function<CoefficientPair(const CoefficientPair&)>& product) const {
    const auto n = static_cast<Index>(2 * shape.cells());
    MatrixXd matrix(n, n);
    for (Index k = 0; k < n; ++k) matrix.col(k) = joined(product(parted(VectorXd::Unit(n, k))));
    return matrix;
  }

  /// Of the posterior, by Hamiltonian Monte Carlo in x = Lᵀ (u − û), in which the Gaussian that
  /// `gaussian` = L Lᵀ stands for is the standard one. `data`: JᵀWJ.
  VectorXd drawn_deviations(const Eigen::LLT<MatrixXd>& gaussian, const MatrixXd& data) {
    const Index n = data.rows();
    const VectorXd centre = joined(fitted_);
    const VectorXd slope = joined(objective_->gradient());
    double potential = 0.0;
    const auto gradient = [&](const VectorXd& x) {
      const VectorXd change = gaussian.matrixU().solve(x);
      const Roughness r = rough(parted(centre + change));
      const VectorXd curved = data * change;
      potential = slope.dot(change) + 0.5 * change.dot(curved) + weight * r.value;
      return VectorXd(gaussian.matrixL().solve(slope + curved + weight * joined(r.gradient)));
    };
    cases::Noise noise(21);
    VectorXd x = VectorXd::Zero(n);
    VectorXd force = gradient(x);
    double energy = potential;
    VectorXd mean = VectorXd::Zero(n);
    VectorXd square = VectorXd::Zero(n);
    int accepted = 0;
    constexpr int draws = 8000;
    constexpr int leaps = 6;
    for (int k = 0; k < draws; ++k) {
      VectorXd momentum(n);
      for (double& p : momentum) p = noise.normal();
      const double before = energy + 0.5 * momentum.squaredNorm();
      const double length = 0.2 + 0.2 * noise.uniform();  // of a leap: no two periods alike
      VectorXd at = x;
      VectorXd g = force;
      for (int leap = 0; leap < leaps; ++leap) {
        momentum -= 0.5 * length * g;
        at += length * momentum;
        g = gradient(at);
        momentum -= 0.5 * length * g;
      }
      if (std::log(noise.uniform()) < before - potential - 0.5 * momentum.squaredNorm()) {
        x = at;
        force = g;
        energy = potential;
        ++accepted;
      }
      const VectorXd change = gaussian.matrixU().solve(x);
      mean += change / draws;
      square += change.cwiseAbs2() / draws;
    }
    EXPECT_GT(accepted, draws / 2);
    return (square - mean.cwiseAbs2()).cwiseSqrt();
  }

  std::unique_ptr<Objective> objective_;
  CoefficientPair fitted_;
};

TEST_F(HuberPosterior, PriorVarianceIsThatOfTheDenseRegulariser) {
  minimise();
  Prior with = prior();
  with.anchor_length_mm = thickness;  // else the mean, the same for both, is most of the variance
  ASSERT_LT(*std::min_element(with.diffusivity.log_kappa.begin(), with.diffusivity.log_kappa.end()),
            0.6);  // there is an edge
  const MatrixXd precision =
      weight * dense([&](const CoefficientPair& v) {
        return smoothing_product(shape, thickness, thickness, with.diffusivity, v);
      });
  const VectorXd exact =
      precision.llt().solve(MatrixXd::Identity(precision.rows(), precision.rows())).diagonal();
  UncertaintyOptions options;
  options.samples = 300;
  options.steps = 12;
  options.pooling = 0.0;
  const VectorXd found = joined(prior_variance(shape, axis, with, options, 1));
  const VectorXd h1 = joined(prior_variance(shape, with));
  const auto error = [&](const VectorXd& v) {
    return v.cwiseQuotient(exact).array().log().abs().maxCoeff();
  };
  std::printf("largest error of a log variance: %.3f, of H1's %.3f\n", error(found), error(h1));
  EXPECT_LT(error(found), 0.15);  // √(2/300) of each voxel, less what the metric knows
  EXPECT_GT(error(h1), 0.2);
}

/// Draws from exp(−½ χ² − α R), χ² linearised at the minimum. Where the prior alone would have
/// neighbours differ by more than δ per voxel, the Gaussian that touches R at its minimum is
/// narrower than R.
TEST_F(HuberPosterior, DeviationsAreThoseOfThePosteriorDrawn) {
  struct Case {
    double edge_slope;
    double lowest;  // 5 % quantile of stated over drawn
  };
  for (const Case& c : {Case{1.0, 0.85}, Case{0.6, 0.65}, Case{0.3, 0.35}}) {
    regulariser.edge_slope = c.edge_slope;
    minimise();
    objective_->value(fitted_);
    const MatrixXd data = dense([&](const CoefficientPair& v) {
      return objective_->jacobian_transpose(objective_->jacobian(v));
    });
    const MatrixXd hessian =
        dense([&](const CoefficientPair& v) { return hessian_product(*objective_, prior(), v); });
    const Index n = hessian.rows();
    const Eigen::LLT<MatrixXd> factor(hessian);
    const VectorXd stated = factor.solve(MatrixXd::Identity(n, n)).diagonal().cwiseSqrt();
    const VectorXd drawn = drawn_deviations(factor, data);
    std::vector<double> ratio;
    for (Index i = 0; i < n; ++i) ratio.push_back(stated[i] / drawn[i]);
    std::sort(ratio.begin(), ratio.end());
    const double low = ratio[ratio.size() / 20];
    const double high = ratio[ratio.size() * 19 / 20];
    std::printf("t = %g, spread %.2f: stated over drawn deviations %.3f, %.3f to %.3f\n",
                c.edge_slope, spread_over_edge(regulariser, weight, shape, thickness),
                ratio[ratio.size() / 2], low, high);
    EXPECT_GT(low, c.lowest);
    EXPECT_LT(high, 1.05);
  }
}

}  // namespace
}  // namespace kappamu::inverse
