// Errors that pixels share: their precision against a dense inverse, and an objective with them
// against differences. What fits make of them: tests/inverse/fit/smooth_error_fit_test.cpp.
#include "inverse/problem/smooth_error.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>

#include "inverse/problem/objective.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using cases::Block;

constexpr FaceShape face{6, 5};
constexpr int patterns = 3;
constexpr int values = 6 * 5 * patterns;
constexpr double signal = 400.0;
constexpr SmoothError error{2e-3, 1e-3};

double wave(int k, int n, int i) {
  return std::sqrt((k == 0 ? 1.0 : 2.0) / n) * std::cos(std::numbers::pi * k * (i + 0.5) / n);
}

/// I + S, summed wave by wave as smooth_error.h states it.
Eigen::MatrixXd covariance() {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Identity(values, values);
  const int cells = face.nu * face.nv;
  for (int kv = 0; kv < face.nv; ++kv) {
    for (int ku = 0; ku < face.nu; ++ku) {
      Eigen::VectorXd map(cells);
      for (int i = 0; i < cells; ++i) {
        map[i] = wave(ku, face.nu, i % face.nu) * wave(kv, face.nv, i / face.nu);
      }
      const double f2 = std::max(
          0.25 / cells, std::pow(ku / (2.0 * face.nu), 2) + std::pow(kv / (2.0 * face.nv), 2));
      const double scale = signal * signal / (2.0 * std::numbers::pi * std::numbers::ln2 * f2);
      const Eigen::MatrixXd outer = map * map.transpose();
      for (int a = 0; a < patterns; ++a) {
        for (int b = 0; b < patterns; ++b) {
          // Of M patterns, M common² of their mean is common² of each pair.
          double between = error.common * error.common;
          if (a == b) between += error.own * error.own;
          sum.block(a * cells, b * cells, cells, cells) += scale * between * outer;
        }
      }
    }
  }
  return sum;
}

TEST(SmoothError, PrecisionIsTheInverseOfTheCovariance) {
  const SmoothErrorPrecision precision(face, patterns, signal, error);
  Eigen::MatrixXd product(values, values);
  Eigen::MatrixXd twice(values, values);
  for (int k = 0; k < values; ++k) {
    std::vector<double> unit(values, 0.0);
    unit[static_cast<std::size_t>(k)] = 1.0;
    std::vector<double> by_root = unit;
    precision.apply(unit);
    precision.apply_root(by_root);
    precision.apply_root(by_root);
    product.col(k) = Eigen::Map<const Eigen::VectorXd>(unit.data(), values);
    twice.col(k) = Eigen::Map<const Eigen::VectorXd>(by_root.data(), values);
  }
  const Eigen::MatrixXd one = covariance() * product;
  EXPECT_LT((one - Eigen::MatrixXd::Identity(values, values)).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT((product - twice).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(SmoothError, AnOctaveOfWavesHasTheStatedSize) {
  // 1 / precision − 1 of the waves between two frequencies, over the pixels, is q² own².
  constexpr FaceShape large{96, 64};
  const SmoothErrorPrecision precision(large, 1, signal, {0.0, 1e-3});
  double sum = 0.0;
  for (int kv = 0; kv < large.nv; ++kv) {
    for (int ku = 0; ku < large.nu; ++ku) {
      const double f = std::hypot(ku / (2.0 * large.nu), kv / (2.0 * large.nv));
      if (f < 0.1 || f >= 0.2) continue;
      std::vector<double> map(large.cells());
      for (std::size_t i = 0; i < map.size(); ++i) {
        map[i] = wave(ku, large.nu, static_cast<int>(i) % large.nu) *
                 wave(kv, large.nv, static_cast<int>(i) / large.nu);
      }
      std::vector<double> weighed = map;
      precision.apply(weighed);
      sum += 1.0 / std::inner_product(map.begin(), map.end(), weighed.begin(), 0.0) - 1.0;
    }
  }
  const double relative = std::sqrt(sum / static_cast<double>(large.cells())) / signal;
  EXPECT_NEAR(relative, 1e-3, 3e-5);
}

TEST(SmoothError, OctavesShareOutWhatThePrecisionMakesOfResiduals) {
  SmoothErrorPrecision precision(face, patterns, signal, error);
  std::vector<double> residuals(values);
  for (int i = 0; i < values; ++i) {
    residuals[static_cast<std::size_t>(i)] = std::sin(1.0 + 0.7 * i) + 5.0;
  }
  std::vector<double> weighed = residuals;
  precision.apply(weighed);
  const double whole = std::inner_product(residuals.begin(), residuals.end(), weighed.begin(), 0.0);
  double count = 0.0;
  double sum = 0.0;
  for (const OctaveMisfit& octave : precision.octaves(residuals)) {
    count += octave.values;
    sum += octave.chi2;
  }
  EXPECT_EQ(count, values);
  EXPECT_NEAR(sum, whole, 1e-9 * whole);
}

TEST(SmoothError, AHeldMeanCountsByItsNoiseAloneAndEachPatternsOwnAsBefore) {
  SmoothErrorPrecision precision(face, patterns, signal, error);
  const std::vector<double> even(values, 1.0);
  const OctaveMisfit stated = precision.octaves(even).front();
  EXPECT_TRUE(stated.of_mean && stated.longest == 0.0 && stated.values == 1.0);
  std::vector<double> own = even;
  for (std::size_t i = 0; i < own.size(); ++i) own[i] = i < own.size() / 3 ? 2.0 : -1.0;
  std::vector<double> before = own;
  precision.apply(before);
  precision.hold_mean(true);
  std::vector<double> weighed = even;
  precision.apply(weighed);
  EXPECT_NEAR(weighed.front(), 1.0, 1e-12);
  EXPECT_EQ(precision.octaves(even).front().chi2, stated.chi2) << "the statement is not held";
  EXPECT_LT(stated.chi2, 0.1 * values);
  precision.apply(own);
  EXPECT_NEAR(own.front(), before.front(), 1e-12);
}

struct ObjectiveCase {
  explicit ObjectiveCase(const SmoothError& shared) {
    Block block;
    block.grid = {8, 6, 4, 0.5};
    SurfaceMeasurements m =
        test_cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2);
    m.smooth_error = shared;
    backend.device = "reference";
    backend.precision = forward::Precision::double_precision;
    backend.solve = {1e-13, 2000};
    objective = std::make_unique<Objective>(
        make_problem(m, 0, forward::Convention::physical, {0.001, 5e-5}), backend);
    at = cases::rough_medium(block.grid, 0.1, 5);
    direction = cases::random_direction(block.grid, 6);
  }
  CoefficientPair moved(double step) const {
    CoefficientPair fields = at;
    for (std::size_t i = 0; i < fields.log_mu.size(); ++i) {
      fields.log_kappa[i] += step * direction.log_kappa[i];
      fields.log_mu[i] += step * direction.log_mu[i];
    }
    return fields;
  }
  double along(const CoefficientPair& gradient) const {
    return std::inner_product(gradient.log_kappa.begin(), gradient.log_kappa.end(),
                              direction.log_kappa.begin(), 0.0) +
           std::inner_product(gradient.log_mu.begin(), gradient.log_mu.end(),
                              direction.log_mu.begin(), 0.0);
  }
  Backend backend;
  std::unique_ptr<Objective> objective;
  CoefficientPair at;
  CoefficientPair direction;
};

TEST(SmoothError, GradientOfTheObjectiveIsExact) {
  ObjectiveCase c({2e-3, 1e-3});
  const double value = c.objective->value(c.at);
  const double slope = c.along(c.objective->gradient());
  std::vector<double> remainders;
  for (const double step : {1e-3, 1e-4}) {
    remainders.push_back(std::abs(c.objective->value(c.moved(step)) - value - step * slope));
  }
  EXPECT_NEAR(std::log10(remainders[0] / remainders[1]), 2.0, 0.05);
  EXPECT_LT(value, ObjectiveCase({}).objective->value(c.at)) << "shared errors only ever excuse";
}

TEST(SmoothError, HessianOfTheDataIsTheCurvatureOfItsMisfit) {
  ObjectiveCase c({2e-3, 1e-3});
  c.objective->value(c.at);
  std::vector<double> seen = c.objective->jacobian(c.direction);
  const std::vector<double> white = seen;
  c.objective->weigh(seen);
  const double curvature = c.along(c.objective->jacobian_transpose(seen));
  EXPECT_NEAR(curvature / std::inner_product(seen.begin(), seen.end(), white.begin(), 0.0), 1.0,
              1e-9);
  // The misfit of a prediction that `seen` moves: ½ (e + h s)ᵀ (I + S)⁻¹ (e + h s).
  const Problem& problem = c.objective->problem();
  const std::vector<double> prediction = c.objective->prediction();
  const auto misfit = [&](double h) {
    std::vector<double> p = prediction;
    for (std::size_t i = 0; i < p.size(); ++i) p[i] += h * white[i] / c.objective->root_weight()[i];
    return evaluate(problem, p, {}).value;
  };
  EXPECT_NEAR((misfit(1.0) - 2.0 * misfit(0.0) + misfit(-1.0)) / curvature, 1.0, 1e-8);
}

TEST(SmoothError, ARobustLossTakesDataForIndependent) {
  ObjectiveCase c({2e-3, 1e-3});
  DataTermOptions huber;
  huber.loss = Loss::huber;
  const ObjectiveCase white({});
  c.objective->value(c.at);
  const std::vector<double> prediction = c.objective->prediction();
  EXPECT_EQ(evaluate(c.objective->problem(), prediction, huber).value,
            evaluate(white.objective->problem(), prediction, huber).value);
}

}  // namespace
}  // namespace kappamu::inverse
