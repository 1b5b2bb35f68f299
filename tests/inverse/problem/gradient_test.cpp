// The gradient is that of the discrete objective: Taylor remainders of order 2 and adjoint
// identities, for every source, face, convention and backend.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "core/numbers/dot.h"
#include "inverse/problem/objective.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

using forward::Convention;
using forward::Precision;
using forward::SourceModel;

struct GradientCase {
  std::string name;
  std::string device = "reference";
  Precision precision = Precision::double_precision;
  Face lit = Face::z_minus;
  Face seen = Face::z_plus;
  Sides sides = Sides::open;
  SourceModel source = SourceModel::first_collision;
  Convention convention = Convention::physical;
  double eta = 1.3;
};

void PrintTo(const GradientCase& c, std::ostream* out) {
  *out << c.name;
}

using kappamu::dot;

double dot(const CoefficientPair& a, const CoefficientPair& b) {
  return dot(a.log_kappa, b.log_kappa) + dot(a.log_mu, b.log_mu);
}

CoefficientPair moved(const CoefficientPair& from, double step, const CoefficientPair& direction) {
  CoefficientPair to = from;
  for (std::size_t i = 0; i < to.log_mu.size(); ++i) {
    to.log_kappa[i] += step * direction.log_kappa[i];
    to.log_mu[i] += step * direction.log_mu[i];
  }
  return to;
}

class Gradient : public ::testing::TestWithParam<GradientCase> {
 protected:
  // Prime extents, thin along the light; 3 patterns.
  static constexpr GridShape shape{7, 5, 4, 0.4};

  void SetUp() override {
    const GradientCase& c = GetParam();
    Problem problem;
    problem.setup = {shape, c.eta, c.lit, c.sides, c.source, c.convention};
    problem.seen_face = c.seen;
    problem.patterns = 3;
    cases::Noise noise(11);
    problem.irradiance.resize(3 * problem.lit_shape().cells());
    for (double& e : problem.irradiance) e = noise.uniform();
    const std::size_t data = 3 * problem.seen_shape().cells();
    for (std::size_t i = 0; i < data; ++i) {
      problem.data.push_back(0.1 * noise.uniform());
      problem.weight.push_back(i % 7 == 0 ? 0.0 : 1.0 + noise.uniform());
    }
    Backend backend{c.device, c.precision, {}, 2, 64.0};  // two batches, the second one short
    backend.solve = c.precision == Precision::double_precision ? forward::SolveOptions{1e-13, 2000}
                                                               : forward::SolveOptions{1e-6, 200};
    objective_ = std::make_unique<Objective>(problem, backend);
    if (c.device != "reference" && objective_->backend_name().find("reference") == 0) {
      GTEST_SKIP() << "no OpenCL device: " << objective_->warning();
    }
    std::vector<double> correction;
    for (std::size_t i = 0; i < data; ++i) correction.push_back(0.9 + 0.2 * noise.uniform());
    objective_->set_correction({correction});
    at_ = cases::rough_medium(shape, 0.4, 5);
    direction_ = cases::random_direction(shape, 6);
  }

  std::unique_ptr<Objective> objective_;
  CoefficientPair at_;
  CoefficientPair direction_;
};

TEST_P(Gradient, TaylorRemainderIsOfOrderTwo) {
  // The remainder must stand above the solver's error: single precision reaches one decade less
  // deep, and starts from larger steps.
  const bool single = GetParam().precision == Precision::single_precision;
  const double value = objective_->value(at_);
  const double slope = dot(objective_->gradient(), direction_);
  std::vector<double> remainders;
  std::vector<double> steps;
  if (single) {
    // Directional derivative against central differences: 1e-3 is rounding over the step.
    constexpr double step = 2e-2;
    const double central = (objective_->value(moved(at_, step, direction_)) -
                            objective_->value(moved(at_, -step, direction_))) /
                           (2.0 * step);
    constexpr double single_precision_floor = 2e-3;
    EXPECT_NEAR(slope / central, 1.0, single_precision_floor);
    return;
  }
  for (double step = 1e-2; step > 0.9e-5; step /= 10.0) {
    steps.push_back(step);
    remainders.push_back(
        std::abs(objective_->value(moved(at_, step, direction_)) - value - step * slope));
  }
  for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
    const double order = std::log10(remainders[k] / remainders[k + 1]);
    EXPECT_NEAR(order, 2.0, 0.05) << "between steps " << steps[k] << " and " << steps[k + 1];
  }
}

TEST_P(Gradient, JacobianAndItsTransposeAgree) {
  if (GetParam().precision == Precision::single_precision)
    GTEST_SKIP() << "differences need double";
  const Problem& problem = objective_->problem();
  cases::Noise noise(23);
  std::vector<double> probe;
  for (std::size_t i = 0; i < problem.data.size(); ++i) probe.push_back(noise.normal());
  const auto weighted = [&](double step) {
    objective_->value(moved(at_, step, direction_));
    std::vector<double> p = objective_->prediction();
    for (std::size_t i = 0; i < p.size(); ++i) p[i] *= std::sqrt(problem.weight[i]);
    return dot(p, probe);
  };
  // Richardson's central difference is exact to step⁴.
  constexpr double step = 1e-3;
  const double first = (weighted(step) - weighted(-step)) / (2.0 * step);
  const double second = (weighted(2.0 * step) - weighted(-2.0 * step)) / (4.0 * step);
  const double forward_product = (4.0 * first - second) / 3.0;
  objective_->value(at_);
  const double adjoint_product = dot(objective_->jacobian_transpose(probe), direction_);
  constexpr double difference_error = 1e-8;
  EXPECT_NEAR(adjoint_product / forward_product, 1.0, difference_error);
}

TEST_P(Gradient, TangentIsTheTransposeOfTheAdjoint) {
  // ⟨p, J d⟩ = ⟨Jᵀ p, d⟩: one linearised forward solve against one adjoint solve.
  objective_->value(at_);
  cases::Noise noise(29);
  std::vector<double> probe;
  for (std::size_t i = 0; i < objective_->problem().data.size(); ++i) {
    probe.push_back(noise.normal());
  }
  const std::vector<double> tangent = objective_->jacobian(direction_);
  const double scale = std::sqrt(dot(probe, probe) * dot(tangent, tangent));
  const double solver_error = GetParam().precision == Precision::double_precision ? 1e-11 : 1e-5;
  EXPECT_NEAR(dot(probe, tangent), dot(objective_->jacobian_transpose(probe), direction_),
              solver_error * scale);
  EXPECT_EQ(objective_->solves().tangent, 1);
}

TEST_P(Gradient, LightAndExitanceAreEachOthersTranspose) {
  // ⟨M light, s⟩ = ⟨light, Mᵀ s⟩, to rounding: A is its own adjoint, and load_transpose() and
  // exitance_transpose() are what they say.
  const GradientCase& c = GetParam();
  const bool exact = c.precision == Precision::double_precision;
  const Problem& problem = objective_->problem();
  const auto op = forward::block_operators()->make(problem.setup, c.seen, c.device, c.precision).op;
  op->set_medium(exponential(at_.log_kappa), exponential(at_.log_mu));
  cases::Noise noise(31);
  constexpr int patterns = 2;
  const auto random = [&](std::size_t size) {
    std::vector<double> values(patterns * size);
    for (double& x : values) x = noise.uniform();
    return values;
  };
  const auto solved = [&](const forward::BatchField& right) {
    auto field = op->make_field(patterns);
    op->solve(right, *field,
              exact ? forward::SolveOptions{1e-14, 2000} : forward::SolveOptions{1e-6, 200});
    return field;
  };
  const std::vector<double> light = random(op->light_size());
  const std::vector<double> s = random(op->exitance_size());
  const auto b = op->make_field(patterns);
  op->load(light, *b);
  std::vector<double> seen(s.size());
  // What the surface reflects without entering is no part of M.
  op->exitance(*solved(*b), std::vector<double>(light.size(), 0.0), seen);
  op->exitance_transpose(s, *b);
  std::vector<double> back(light.size());
  op->load_transpose(*solved(*b), back);
  EXPECT_NEAR(dot(seen, s) / dot(light, back), 1.0, exact ? 1e-11 : 1e-4);
}

std::vector<GradientCase> gradient_cases() {
  const GradientCase basic{.name = "BackLit"};
  std::vector<GradientCase> list{basic};
  const auto add = [&](const std::string& name, auto change) {
    GradientCase c = basic;
    c.name = name;
    change(c);
    list.push_back(c);
  };
  add("FrontLit", [](GradientCase& c) { c.seen = Face::z_minus; });
  add("FromXPlusMirrorSides", [](GradientCase& c) {
    c.lit = Face::x_plus;
    c.seen = Face::x_minus;
    c.sides = Sides::mirror;
  });
  add("BeamMuchReflected", [](GradientCase& c) { c.eta = 3.0; });
  add("BoundarySource", [](GradientCase& c) { c.source = SourceModel::boundary; });
  add("BoundarySourceFrontLit", [](GradientCase& c) {
    c.source = SourceModel::boundary;
    c.seen = Face::z_minus;
  });
  add("Wang2008FrontLit", [](GradientCase& c) {
    c.source = SourceModel::boundary;
    c.convention = Convention::wang2008;
    c.seen = Face::z_minus;
  });
  add("SideSeenFromYPlus", [](GradientCase& c) {
    c.lit = Face::y_plus;
    c.seen = Face::x_minus;
  });
  add("OpenClDouble", [](GradientCase& c) { c.device = "auto"; });
  add("OpenClDoubleFrontLit", [](GradientCase& c) {
    c.device = "auto";
    c.seen = Face::z_minus;
    c.source = SourceModel::boundary;
  });
  add("OpenClSingle", [](GradientCase& c) {
    c.device = "auto";
    c.precision = Precision::single_precision;
  });
  return list;
}

INSTANTIATE_TEST_SUITE_P(EverySetup, Gradient, ::testing::ValuesIn(gradient_cases()),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace kappamu::inverse
