// The even change that stands for structure finer than a fit: none where nothing is smoothed, and
// otherwise the one that best brings back the light.
#include "inverse/uncertainty/unresolved_structure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/numbers/gaussian_sum.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

class UnresolvedStructure : public ::testing::Test {
 protected:
  static constexpr GridShape shape{8, 8, 4, 0.5};
  const Prior prior{1.0, 20.0};

  void SetUp() override {
    cases::Noise noise(5);
    Problem problem = cases::randomly_lit(shape, 4, noise);
    problem.data = cases::simulate(problem.setup, rough_, problem.seen_face, problem.irradiance, 4,
                                   "reference");
    for (const double d : problem.data) problem.weight.push_back(std::pow(0.01 * d, -2));
    objective_ = std::make_unique<Objective>(
        problem,
        Backend{"reference", forward::Precision::double_precision, {1e-12, 2000}, 16, 64.0});
  }

  static PointSpread wide(double mm) { return {Vector(4, mm), Vector(4, mm)}; }

  /// Half of χ² to the light of the rough medium, of its means over `mm` and an even change.
  double misfit(double mm, EvenChange change) {
    const auto means = [&](const Vector& field, double even) {
      Vector smooth =
          gaussian_means(Volume<double>(shape, field), Face::z_minus, Vector(4, mm)).values();
      for (double& x : smooth) x += even;
      return smooth;
    };
    return objective_->value(
        {means(rough_.log_kappa, change.log_kappa), means(rough_.log_mu, change.log_mu)});
  }

  const CoefficientPair rough_ = cases::rough_medium(shape, 0.2, 5);
  std::unique_ptr<Objective> objective_;
};

TEST_F(UnresolvedStructure, NothingSmoothedNothingMissed) {
  const EvenChange none = unresolved_structure(*objective_, rough_, wide(0.0), prior);
  EXPECT_NEAR(none.log_kappa, 0.0, 1e-9);
  EXPECT_NEAR(none.log_mu, 0.0, 1e-9);
  const CoefficientPair even{Vector(shape.cells(), std::log(0.3)),
                             Vector(shape.cells(), std::log(0.02))};
  const EvenChange of_even = unresolved_structure(*objective_, even, wide(3.0), prior);
  EXPECT_NEAR(of_even.log_kappa, 0.0, 1e-6);
  EXPECT_NEAR(of_even.log_mu, 0.0, 1e-6);
}

TEST_F(UnresolvedStructure, IsTheEvenChangeThatBringsBackTheLight) {
  for (const double mm : {1.0, 4.0}) {
    const EvenChange found = unresolved_structure(*objective_, rough_, wide(mm), prior);
    const double at = misfit(mm, found);
    EXPECT_LT(at, misfit(mm, {})) << mm;
    constexpr double aside = 0.5;  // of the change, whose second order is nothing beside that
    EXPECT_LT(at, misfit(mm, {(1.0 + aside) * found.log_kappa, found.log_mu})) << mm;
    EXPECT_LT(at, misfit(mm, {(1.0 - aside) * found.log_kappa, found.log_mu})) << mm;
    EXPECT_LT(at, misfit(mm, {found.log_kappa, (1.0 + aside) * found.log_mu})) << mm;
    EXPECT_LT(at, misfit(mm, {found.log_kappa, (1.0 - aside) * found.log_mu})) << mm;
  }
}

TEST_F(UnresolvedStructure, WhatDataDoNotSayIsNotMissed) {
  const Prior stiff{1e18, 20.0};
  const EvenChange none = unresolved_structure(*objective_, rough_, wide(4.0), stiff);
  EXPECT_LT(std::abs(none.log_kappa), 1e-6);
  EXPECT_LT(std::abs(none.log_mu), 1e-6);
}

TEST_F(UnresolvedStructure, LeavesTheObjectiveAtTheFit) {
  const double before = objective_->value(rough_);
  unresolved_structure(*objective_, rough_, wide(2.0), prior);
  Vector zero(objective_->prediction().size(), 0.0);
  EXPECT_NEAR(before, 0.0, 1e-9) << "its own data";
  for (std::size_t i = 0; i < zero.size(); ++i) {
    zero[i] = objective_->prediction()[i] / objective_->problem().data[i] - 1.0;
  }
  EXPECT_LT(std::abs(*std::max_element(zero.begin(), zero.end())), 1e-6);
}

}  // namespace
}  // namespace kappamu::inverse
