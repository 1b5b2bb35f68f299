// Least squares of few unknowns: known minima, valleys, directions that nothing determines, and how
// few evaluations they take.
#include "inverse/optimise/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace kappamu::inverse {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// r and ∂r/∂p by formula, counted.
struct Formula : Residuals {
  std::function<VectorXd(const VectorXd&)> of;
  std::function<MatrixXd(const VectorXd&)> slope;
  int evaluations = 0;
  int jacobians = 0;

  VectorXd residual(const VectorXd& p) override {
    ++evaluations;
    return of(p);
  }
  MatrixXd jacobian(const VectorXd& p) override {
    ++jacobians;
    return slope(p);
  }
};

const LinearPrior none{MatrixXd::Zero(0, 2), VectorXd::Zero(0)};

LevenbergMarquardtReport minimise(Residuals& residuals, LeastSquaresState& at,
                                  const LinearPrior& prior = none,
                                  LevenbergMarquardtOptions options = {}) {
  at.residual = residuals.residual(at.p);
  return levenberg_marquardt(residuals, prior, at, options, [](const PlannedStep& next) {
    return next.step.cwiseAbs().maxCoeff() < 1e-8 ? Continue::converged : Continue::yes;
  });
}

Formula rosenbrock() {
  Formula f;
  f.of = [](const VectorXd& p) { return Vector2d(10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]); };
  f.slope = [](const VectorXd& p) {
    MatrixXd j(2, 2);
    j << -20.0 * p[0], 10.0, -1.0, 0.0;
    return j;
  };
  return f;
}

TEST(LevenbergMarquardt, FollowsRosenbrocksValleyToItsEnd) {
  for (const double most_bend : {0.0, 0.75}) {
    Formula f = rosenbrock();
    LeastSquaresState at{Vector2d(-1.2, 1.0), {}, {}};
    const LevenbergMarquardtReport report =
        minimise(f, at, none, {.most_steps = 60, .most_bend = most_bend});
    EXPECT_TRUE(report.converged);
    EXPECT_LT((at.p - Vector2d(1.0, 1.0)).norm(), 1e-7);
    EXPECT_LT(at.residual.norm(), 1e-7);
    EXPECT_LE(f.evaluations, 50) << "bend " << most_bend;
    EXPECT_LE(f.jacobians, 25) << "bend " << most_bend;
  }
}

TEST(LevenbergMarquardt, LinearResidualsNeedOneJacobian) {
  Formula f;
  const Eigen::Matrix<double, 3, 2> a{{2.0, 1.0}, {0.0, 3.0}, {1.0, -1.0}};
  f.of = [a](const VectorXd& p) { return VectorXd(a * p - Eigen::Vector3d(4.0, 3.0, 2.0)); };
  f.slope = [a](const VectorXd&) { return a; };
  LeastSquaresState at{Vector2d(0.5, 0.5), {}, {}};
  EXPECT_TRUE(minimise(f, at).converged);
  EXPECT_EQ(f.jacobians, 1);
  EXPECT_LT((a.transpose() * at.residual).norm(), 1e-7);
  const int before = f.evaluations;
  EXPECT_TRUE(minimise(f, at).converged) << "again from its end, with the Jacobian kept";
  EXPECT_EQ(f.jacobians, 1);
  EXPECT_EQ(f.evaluations, before + 1);
}

TEST(LevenbergMarquardt, WhatNothingDeterminesStays) {
  Formula f;
  f.of = [](const VectorXd& p) { return VectorXd::Constant(1, p[0] + p[1] - 3.0); };
  f.slope = [](const VectorXd&) { return MatrixXd::Ones(1, 2); };
  LeastSquaresState at{Vector2d(0.0, 1.0), {}, {}};
  EXPECT_TRUE(minimise(f, at).converged);
  EXPECT_NEAR(at.p[0] + at.p[1], 3.0, 1e-7);
  EXPECT_NEAR(at.p[0] - at.p[1], -1.0, 1e-6) << "moved across the valley alone";

  // An unknown that r does not know at all, and then the prior's word on it.
  f.slope = [](const VectorXd&) { return MatrixXd{{1.0, 0.0}}; };
  f.of = [](const VectorXd& p) { return VectorXd::Constant(1, p[0] - 3.0); };
  at = {Vector2d(0.0, 1.0), {}, {}};
  EXPECT_TRUE(minimise(f, at).converged);
  EXPECT_NEAR(at.p[0], 3.0, 1e-7);
  EXPECT_EQ(at.p[1], 1.0);
  const LinearPrior weak{MatrixXd{{1e-3, 1e-3}}, VectorXd::Constant(1, 8e-3)};
  EXPECT_TRUE(minimise(f, at, weak).converged);
  EXPECT_NEAR(at.p[0], 3.0, 1e-5);
  EXPECT_NEAR(at.p[1], 5.0, 1e-4);
  EXPECT_LT(weak.square(at.p), 1e-12);
}

/// Powell's singular function: the Jacobian has rank two at the minimum.
TEST(LevenbergMarquardt, ReachesAMinimumWhereTheJacobianIsSingular) {
  Formula f;
  f.of = [](const VectorXd& p) {
    return Eigen::Vector4d(p[0] + 10.0 * p[1], std::sqrt(5.0) * (p[2] - p[3]),
                           std::pow(p[1] - 2.0 * p[2], 2),
                           std::sqrt(10.0) * std::pow(p[0] - p[3], 2));
  };
  f.slope = [](const VectorXd& p) {
    const double a = 2.0 * (p[1] - 2.0 * p[2]);
    const double b = 2.0 * std::sqrt(10.0) * (p[0] - p[3]);
    return MatrixXd{{1.0, 10.0, 0.0, 0.0},
                    {0.0, 0.0, std::sqrt(5.0), -std::sqrt(5.0)},
                    {0.0, a, -2.0 * a, 0.0},
                    {b, 0.0, 0.0, -b}};
  };
  LeastSquaresState at{Eigen::Vector4d(3.0, -1.0, 0.0, 1.0), {}, {}};
  const LinearPrior of_four{MatrixXd::Zero(0, 4), VectorXd::Zero(0)};
  minimise(f, at, of_four, {.most_steps = 60});
  EXPECT_LT(at.residual.norm(), 1e-6) << "14.7 at the start";
  EXPECT_LT(at.p.norm(), 1e-2);
}

TEST(LevenbergMarquardt, GoesAroundWhereThereIsNoResidual) {
  Formula f;
  f.of = [](const VectorXd& p) {
    return p[0] > 0.0 ? VectorXd(Vector2d(std::log(p[0]) + 2.0, p[1])) : VectorXd();
  };
  f.slope = [](const VectorXd& p) { return MatrixXd{{1.0 / p[0], 0.0}, {0.0, 1.0}}; };
  LeastSquaresState at{Vector2d(3.0, 1.0), {}, {}};  // Newton's first step ends at −6.3
  EXPECT_TRUE(minimise(f, at, none, {.most_steps = 60, .longest_step = 100.0}).converged);
  EXPECT_NEAR(at.p[0], std::exp(-2.0), 1e-7);

  f.slope = [](const VectorXd&) { return MatrixXd(); };
  at = {Vector2d(3.0, 1.0), {}, {}};
  EXPECT_FALSE(minimise(f, at).converged) << "no Jacobian, no step";
  EXPECT_EQ(at.p, Vector2d(3.0, 1.0));
}

TEST(LevenbergMarquardt, KeepsToBoundsAndToTheLongestStep) {
  struct Bounded : Formula {
    VectorXd bounded(const VectorXd& p) const override { return p.cwiseMin(0.75); }
  } f;
  f.of = [](const VectorXd& p) { return VectorXd(p - Vector2d(2.0, 0.5)); };
  f.slope = [](const VectorXd&) { return MatrixXd::Identity(2, 2); };
  LeastSquaresState at{Vector2d(0.0, 0.0), {}, {}};
  double longest = 0.0;
  at.residual = f.residual(at.p);
  levenberg_marquardt(f, none, at, {.longest_step = 0.3}, [&](const PlannedStep& next) {
    longest = std::max(longest, next.step.cwiseAbs().maxCoeff());
    EXPECT_GE(next.hoped, next.promised);
    return next.step.norm() < 1e-8 ? Continue::converged : Continue::yes;
  });
  EXPECT_LE(longest, 0.3 + 1e-12);
  EXPECT_EQ(at.p[0], 0.75);
  EXPECT_NEAR(at.p[1], 0.5, 1e-3) << "by steps cut for the other unknown";
}

/// Reweighted to absolute values, the median of three is found where plain squares find the mean.
TEST(LevenbergMarquardt, WeighsAnewBeforeEveryStep) {
  struct Robust : Formula {
    VectorXd weights(const VectorXd& r) override {
      return r.cwiseAbs().cwiseMax(1e-3).cwiseInverse();
    }
  } f;
  f.of = [](const VectorXd& p) { return VectorXd(Eigen::Vector3d(0.0, 1.0, 9.0).array() - p[0]); };
  f.slope = [](const VectorXd&) { return MatrixXd::Constant(3, 1, -1.0); };
  const LinearPrior of_one{MatrixXd::Zero(0, 1), VectorXd::Zero(0)};
  LeastSquaresState at{VectorXd::Constant(1, 4.0), {}, {}};
  minimise(f, at, of_one, {.most_steps = 100, .longest_step = 10.0});
  EXPECT_NEAR(at.p[0], 1.0, 0.05);
}

TEST(LevenbergMarquardt, CheapColumnsAreExactAtEveryStepAndGivingUpIsNotConvergence) {
  struct Cheap : Formula {
    void set_cheap_columns(const VectorXd& p, MatrixXd& j) override { j.col(1) = slope(p).col(1); }
  } f;
  static_cast<Formula&>(f) = rosenbrock();
  LeastSquaresState at{Vector2d(-1.2, 1.0), {}, {}};
  EXPECT_TRUE(minimise(f, at, none, {.most_steps = 60, .cheap_columns = 1}).converged);
  EXPECT_LT((at.p - Vector2d(1.0, 1.0)).norm(), 1e-7);
  EXPECT_EQ(at.jacobian(0, 1), 10.0);
  EXPECT_EQ(at.jacobian(1, 1), 0.0);

  at = {Vector2d(-1.2, 1.0), f.residual(Vector2d(-1.2, 1.0)), {}};
  const LevenbergMarquardtReport report = levenberg_marquardt(
      f, none, at, {},
      [](const PlannedStep& next) { return next.cost < 4.0 ? Continue::give_up : Continue::yes; });
  EXPECT_FALSE(report.converged);
  EXPECT_GT(report.steps, 0);
  EXPECT_LT(at.residual.squaredNorm(), 4.0);
}

}  // namespace
}  // namespace kappamu::inverse
