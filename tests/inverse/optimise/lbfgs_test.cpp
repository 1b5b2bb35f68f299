// The direction of L-BFGS from inner products is that of the algorithm's two loops.
#include "inverse/optimise/lbfgs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/numbers/dot.h"
#include "inverse/defaults.h"
#include "inverse/optimise/host_vectors.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

/// Only its total() is asked for: of vectors that two processes hold alike.
class Halves final : public Function {
 public:
  double value(const Vector&) override { return 0.0; }
  Vector gradient() override { return {}; }
  double amplitude(const Vector&, const Vector&) override { return 0.0; }
  void total(std::span<double> products) const override {
    for (double& p : products) p *= 2.0;
  }
};

Vector doubles(const std::vector<float>& v) {
  return {v.begin(), v.end()};
}

/// −H g by algorithm 7.4, of the pairs of positive curvature.
Vector two_loops(const OptimiserState& state) {
  std::vector<std::size_t> usable;
  for (std::size_t k = 0; k < state.steps.size(); ++k) {
    if (dot(doubles(state.steps[k]), doubles(state.changes[k])) > 0.0) usable.push_back(k);
  }
  Vector d = state.gradient;
  std::vector<double> alpha(state.steps.size());
  const auto add = [&](double factor, const Vector& v) {
    for (std::size_t i = 0; i < d.size(); ++i) d[i] += factor * v[i];
  };
  for (std::size_t n = usable.size(); n-- > 0;) {
    const Vector s = doubles(state.steps[usable[n]]), y = doubles(state.changes[usable[n]]);
    alpha[n] = dot(s, d) / dot(s, y);
    add(-alpha[n], y);
  }
  const Vector s = doubles(state.steps[usable.back()]), y = doubles(state.changes[usable.back()]);
  for (double& x : d) x *= defaults::optimiser::softer * dot(s, y) / dot(y, y);
  for (std::size_t n = 0; n < usable.size(); ++n) {
    const Vector sn = doubles(state.steps[usable[n]]), yn = doubles(state.changes[usable[n]]);
    add(alpha[n] - dot(yn, d) / dot(sn, yn), sn);
  }
  for (double& x : d) x = -x;
  return d;
}

class Pairs {
 public:
  /// No multiple of a vector register, more than a piece of for_pieces().
  static constexpr std::size_t size = 70003;

  std::vector<float> random() {
    std::vector<float> v(size);
    for (float& x : v) x = static_cast<float>(noise_.normal());
    return v;
  }
  /// A change of about `curvature` times the step.
  void add(OptimiserState& state, float curvature) {
    state.steps.push_back(random());
    state.changes.push_back(random());
    for (std::size_t i = 0; i < size; ++i) {
      const float own = curvature * (1.0F + static_cast<float>(i % 5));
      state.changes.back()[i] = 0.3F * state.changes.back()[i] + own * state.steps.back()[i];
    }
  }
  void set_gradient(OptimiserState& state) {
    const std::vector<float> g = random();
    state.gradient.assign(g.begin(), g.end());
  }

 private:
  cases::Noise noise_{7};
};

void expect_two_loops(OptimiserState& state) {
  const Vector expected = two_loops(state);
  Halves halves;
  HostVectors vectors(halves, state);
  const double found = lbfgs_descent(vectors, state.products);
  const Vector& direction = vectors.direction();
  ASSERT_EQ(direction.size(), expected.size());
  double error = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    error += std::pow(direction[i] - expected[i], 2);
  }
  EXPECT_LT(std::sqrt(error / dot(expected, expected)), 1e-11);
  const double slope = 2.0 * dot(expected, state.gradient);
  EXPECT_NEAR(found, slope, 1e-11 * std::abs(slope));
}

TEST(Lbfgs, DirectionIsThatOfTheTwoLoops) {
  Pairs pairs;
  OptimiserState state;
  pairs.set_gradient(state);
  for (const float curvature : {1.0F, 0.3F, -2.0F, 5.0F}) pairs.add(state, curvature);
  expect_two_loops(state);
  // A new pair, a new gradient, and the same pairs again: products of the old ones are kept.
  pairs.add(state, 2.0F);
  pairs.set_gradient(state);
  expect_two_loops(state);
  pairs.set_gradient(state);
  expect_two_loops(state);
}

TEST(Lbfgs, DescendsAlongTheGradientWherePairsAreOfNoUse) {
  Pairs pairs;
  OptimiserState state;
  pairs.set_gradient(state);
  for (int count = 0; count < 2; ++count) {
    Halves halves;
    HostVectors vectors(halves, state);
    lbfgs_descent(vectors, state.products);
    for (std::size_t i = 0; i < Pairs::size; ++i) {
      ASSERT_EQ(vectors.direction()[i], -state.gradient[i]);
    }
    pairs.add(state, -1.0F);
  }
}

}  // namespace
}  // namespace kappamu::inverse
