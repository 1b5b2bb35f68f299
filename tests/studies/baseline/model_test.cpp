// The papers' solvers: they reach the reference's solution where their equations are ours, in as
// many sweeps as theory says, and fail where and how theory says. Bad input to the shared parts is
// tested with the grid solvers; the command in tests/app/forward_command_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/cases/media.h"
#include "tests/sentence.h"
#include "tests/studies/baseline/tools.h"

namespace kappamu::forward::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Baseline : public ::testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }
};

struct Case {
  const char* name;
  Face lit;
  Sides sides;
  SourceModel source;
  Convention convention;
};
class BaselineAgreement : public Baseline,
                          public ::testing::WithParamInterface<std::tuple<const char*, Case>> {};

TEST_P(BaselineAgreement, ConvergesToTheReference) {
  const auto& [method, c] = GetParam();
  // Odd extents leave single children on every level; five patterns leave lanes empty.
  ForwardProblem problem = random_problem({11, 7, 5, 0.4}, c.lit, 10.0, 5);
  problem.setup.sides = c.sides;
  problem.setup.source = c.source;
  problem.setup.convention = c.convention;
  const ForwardResult expected = solve("reference", problem, 1e-12);
  const ForwardResult found = solve(method, problem, 1e-10);
  EXPECT_EQ(found.termination, Termination::converged) << found.message;
  // ‖error‖ ≤ cond · residual, and these small blocks' condition numbers are below 1e3.
  constexpr double condition_times_tolerance = 1e-7;
  for (std::size_t f = 0; f < 6; ++f) {
    if (norm(expected.exitance[f]) == 0.0) continue;  // a mirror
    EXPECT_LT(relative_difference(found.exitance[f], expected.exitance[f]),
              condition_times_tolerance)
        << to_string(all_faces[f]);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Methods, BaselineAgreement,
    ::testing::Combine(
        // Blocks this small have no cell deep enough to stay at rest, so adaptive is exact too.
        ::testing::Values("relaxation", "gauss-seidel", "hierarchical", "adaptive"),
        ::testing::Values(Case{"PhysicalBeam", Face::z_minus, Sides::open,
                               SourceModel::first_collision, Convention::physical},
                          Case{"DiffuseBetweenMirrors", Face::x_plus, Sides::mirror,
                               SourceModel::boundary, Convention::physical},
                          Case{"Wang2008", Face::y_minus, Sides::open, SourceModel::boundary,
                               Convention::wang2008})),
    [](const auto& instance) {
      std::string method = std::get<0>(instance.param);
      std::erase(method, '-');
      return method + std::get<1>(instance.param).name;
    });

TEST_F(Baseline, SameInputGivesSameBits) {
  const ForwardProblem problem = random_problem({13, 9, 6, 0.3}, Face::z_minus, 10.0, 3);
  for (const char* method : {"relaxation", "gauss-seidel", "adaptive", "wang2008-stencil"}) {
    const ForwardResult a = solve(method, problem, 1e-2, Precision::single_precision);
    const ForwardResult b = solve(method, problem, 1e-2, Precision::single_precision);
    EXPECT_EQ(a.exitance, b.exitance) << method;
    EXPECT_EQ(a.iterations, b.iterations) << method;
  }
}

TEST_F(Baseline, SweepsGrowWithTheSquareOfTheExtent) {
  // Between mirrors only the depth n counts: Jacobi's slowest mode shrinks by 1 − O(1/n²) a sweep.
  for (const char* method : {"relaxation", "gauss-seidel"}) {
    std::vector<double> sweeps;
    for (const int n : {5, 10, 20}) {
      ForwardProblem problem = uniform_problem({2, 2, n, 8.0 / n});
      problem.setup.sides = Sides::mirror;
      problem.medium.mu = Volume<double>(problem.setup.shape, 0.0);
      sweeps.push_back(solve(method, problem, 1e-6).iterations);
    }
    // Residuals are looked at every 16th sweep more, which rounds each count up by 6 % at most.
    for (std::size_t k = 1; k < sweeps.size(); ++k) {
      EXPECT_NEAR(std::log2(sweeps[k] / sweeps[k - 1]), 2.0, 0.25) << method << " " << sweeps[k];
    }
  }
}

TEST_F(Baseline, GaussSeidelNeedsHalfOfJacobisSweeps) {
  // Its matrix is consistently ordered, so its factor per sweep is Jacobi's squared (Young 1954).
  ForwardProblem problem = random_problem({11, 11, 11, 0.7}, Face::z_minus, 10.0, 1);
  const double jacobi = solve("relaxation", problem, 1e-8).iterations;
  const double gauss_seidel = solve("gauss-seidel", problem, 1e-8).iterations;
  EXPECT_NEAR(gauss_seidel / jacobi, 0.5, 0.06);  // counts are rounded up by 6 % at most
}

TEST_F(Baseline, CoarseStartSavesSweepsButNotTheRate) {
  ForwardProblem problem = uniform_problem({20, 20, 20, 0.5});
  const double loose = 1e-2, tight = 1e-9;
  const int from_zero = solve("relaxation", problem, tight).iterations;
  EXPECT_LT(solve("hierarchical", problem, loose).iterations,
            solve("relaxation", problem, loose).iterations);
  // The slowest modes shrink as slowly as before: most sweeps to a tight tolerance remain.
  const int hierarchical = solve("hierarchical", problem, tight).iterations;
  EXPECT_LT(hierarchical, from_zero);
  EXPECT_GT(hierarchical, from_zero / 3);
}

TEST_F(Baseline, AdaptiveStaysWithinTheErrorTheAuthorsAllow) {
  // [W] Fig. 15: Σ(L − L₀)²/ΣL₀² over the surface below 0.5 %, at lower cost.
  constexpr double allowed = 0.005;
  const ForwardProblem problem = random_problem({40, 40, 40, 0.25}, Face::z_minus, 10.0, 1);
  const ForwardResult all = solve("hierarchical", problem, 1e-5);
  const ForwardResult adaptive = solve("adaptive", problem, 1e-5);
  EXPECT_EQ(adaptive.termination, Termination::converged) << adaptive.message;
  double error = 0.0, scale = 0.0;
  for (std::size_t f = 0; f < 6; ++f) {
    const double d = relative_difference(adaptive.exitance[f], all.exitance[f]);
    const double s = norm(all.exitance[f]);
    error += d * d * s * s;
    scale += s * s;
  }
  EXPECT_LT(error / scale, allowed);
  EXPECT_LT(adaptive.iterations, all.iterations);
  // What it leaves unsolved is seen on the far face, and as power gone astray.
  const std::size_t far = 5;
  EXPECT_GT(relative_difference(adaptive.exitance[far], all.exitance[far]), 1e-2);
  EXPECT_GT(imbalance(adaptive), 10.0 * imbalance(all));
}

TEST_F(Baseline, RelaxationSaysWhenSweepsRunOut) {
  const ForwardProblem problem = uniform_problem({32, 32, 32, 0.5});
  ForwardOptions options = options_for(1e-6, Precision::double_precision);
  options.solve.max_iterations = 50;
  Progress progress;
  const ForwardResult result =
      baseline::make_model("relaxation")->solve(problem, options, progress);
  EXPECT_EQ(result.termination, Termination::ran_out);
  EXPECT_EQ(result.iterations, 50);
  EXPECT_THAT(result.message, HasSubstr("more are needed"));
}

TEST_F(Baseline, ResidualPerSweepTendsToOneUntilFloatStalls) {
  // A long pipe: 1 − factor falls like 1/n², until a sweep's gain is below float's rounding.
  double last_gain = 1.0;
  for (const int n : {16, 64}) {
    ForwardProblem problem = uniform_problem({1, 1, n, 0.25});
    problem.setup.sides = Sides::mirror;
    problem.medium.mu = Volume<double>(problem.setup.shape, 0.0);
    ForwardOptions options = options_for(1e-12, Precision::double_precision);
    options.solve.max_iterations = n * n / 2;
    const auto model = baseline::make_model("relaxation");
    Progress progress;
    const double half = model->solve(problem, options, progress).residual[0];
    options.solve.max_iterations = n * n;
    const double whole = model->solve(problem, options, progress).residual[0];
    const double gain = 1.0 - std::pow(whole / half, 2.0 / (n * n));
    EXPECT_LT(gain, last_gain / 8.0);
    last_gain = gain;
  }
  ForwardProblem problem = uniform_problem({1, 1, 200, 0.25});
  problem.setup.sides = Sides::mirror;
  problem.medium.mu = Volume<double>(problem.setup.shape, 0.0);
  ForwardOptions options = options_for(1e-7, Precision::single_precision);
  options.solve.max_iterations = 4'000'000;
  Progress progress;
  const ForwardResult stalled =
      baseline::make_model("relaxation")->solve(problem, options, progress);
  EXPECT_EQ(stalled.termination, Termination::ran_out);
  EXPECT_THAT(stalled.message, HasSubstr("stalled, this is single precision's floor"));
  EXPECT_LT(stalled.iterations, options.solve.max_iterations);
}

TEST_F(Baseline, StallsAtTheFloorOfItsOwnPrecision) {
  const ForwardProblem problem = random_problem({8, 8, 8, 0.75}, Face::z_minus, 1e3, 2);
  for (const char* method : {"relaxation", "gauss-seidel"}) {
    // ‖b‖ is spread over the lit face, so that u ‖Dφ‖/‖b‖ is a few hundred u.
    const ForwardResult in_float = solve(method, problem, 1e-15, Precision::single_precision);
    EXPECT_THAT(in_float.message, HasSubstr("single precision's floor")) << method;
    EXPECT_THAT(in_float.message, HasSubstr("double precision goes lower")) << method;
    const ForwardResult in_double = solve(method, problem, 1e-18);
    EXPECT_THAT(in_double.message, HasSubstr("double precision's floor")) << method;
    EXPECT_THAT(in_double.message, Not(HasSubstr("double precision goes lower"))) << method;
    constexpr double units = 1e3;
    for (const auto& [result, unit] :
         {std::pair{&in_float, 6e-8}, std::pair{&in_double, 1.1e-16}}) {
      EXPECT_EQ(result->termination, Termination::ran_out) << method;
      EXPECT_LT(*std::max_element(result->residual.begin(), result->residual.end()), units * unit)
          << method;
    }
  }
}

TEST_F(Baseline, ResidualsThatRiseOrRestFirstAreNoStall) {
  // Balls of 100 times κ: it takes hundreds of sweeps until any of their power has come out.
  ForwardProblem problem = uniform_problem({24, 24, 24, 0.33});
  problem.irradiance = test_cases::patch_light(problem.setup.shape, problem.setup.lit_face, 1);
  problem.medium = test_cases::make_medium(
      problem.setup.shape, {.kind = test_cases::MediumKind::inclusions, .contrast = 1e4});
  ForwardOptions options = options_for(1e-3, Precision::single_precision);
  options.solve.max_iterations = 180;
  const auto model = baseline::make_model("gauss-seidel");
  Progress progress;
  const ForwardResult early = model->solve(problem, options, progress);
  EXPECT_GT(early.residual[0], 1.0);
  EXPECT_EQ(early.iterations, 180) << "it must not stop before its sweeps run out";
  EXPECT_THAT(early.message, Not(HasSubstr("stalled")));
  options.solve.max_iterations = 100'000;
  const ForwardResult late = model->solve(problem, options, progress);
  EXPECT_EQ(late.termination, Termination::converged) << late.message;
  EXPECT_LT(relative_difference(late.exitance[5], solve("multigrid", problem, 1e-9).exitance[5]),
            0.01);
}

TEST_F(Baseline, ReferenceDeviceIsRefused) {
  ForwardOptions options;
  options.device = "reference";
  Progress progress;
  const auto model = baseline::make_model("hierarchical");
  EXPECT_THAT(sentence_of([&] {
                model->solve(uniform_problem({4, 4, 4, 0.5}), options, progress);
              }),
              HasSubstr("'hierarchical' runs on OpenCL devices only"));
}

}  // namespace
}  // namespace kappamu::forward::testing
