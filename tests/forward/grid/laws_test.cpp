// Laws of the discrete operator, on every backend. Convergence towards the continuous equations is
// in grid_order_test.cpp, agreement between backends in grid_equivalence_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "forward/grid/grid_physics.h"
#include "forward/grid/power_balance.h"
#include "tests/forward/grid/backends.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Coefficients;
using testing::Values;

constexpr GridShape block{13, 11, 7, 0.4};

class GridLaws : public testing::OnBackend {};

TEST_P(GridLaws, OperatorIsSymmetric) {
  GridSetup setup{.shape = block};
  const auto s = solver(setup);
  const Coefficients c = testing::random_medium(block, 100, 1);
  s->set_medium(c.kappa, c.mu);
  const Values a = testing::random_values(block.cells(), -1, 1, 2);
  const Values b = testing::random_values(block.cells(), -1, 1, 3);
  const auto fa = s->make_field(1), fb = s->make_field(1);
  const auto aa = s->make_field(1), ab = s->make_field(1);
  s->fill(*fa, a);
  s->fill(*fb, b);
  s->apply(*fa, *aa);
  s->apply(*fb, *ab);
  const Values image_a = testing::read(*s, *aa);
  const Values image_b = testing::read(*s, *ab);
  const double scale = testing::norm(image_a) * testing::norm(b);
  EXPECT_NEAR(dot(image_a, b), dot(a, image_b), rounding() * scale);
}

TEST_P(GridLaws, OperatorIsPositive) {
  GridSetup setup{.shape = block, .sides = Sides::mirror};
  const auto s = solver(setup);
  const Coefficients c = testing::random_medium(block, 100, 1);
  s->set_medium(c.kappa, Values(block.cells(), 0.0));
  const auto x = s->make_field(1), y = s->make_field(1);
  for (const double low : {-1.0, 0.9}) {  // rough fields and nearly constant ones
    const Values values = testing::random_values(block.cells(), low, 1, 4);
    s->fill(*x, values);
    s->apply(*x, *y);
    EXPECT_GT(dot(values, testing::read(*s, *y)), 0.0);
  }
}

/// entering = exiting + unscattered + absorbed, for every source, sides and lit face.
TEST_P(GridLaws, PowerBalances) {
  constexpr double tolerance = 1e-6;
  constexpr int patterns = 2;
  const Coefficients c = testing::random_medium(block, 30, 5);
  const Medium medium{Volume<double>(block, c.kappa), Volume<double>(block, c.mu)};
  for (const SourceModel source : {SourceModel::first_collision, SourceModel::boundary}) {
    for (const Sides sides : {Sides::open, Sides::mirror}) {
      for (const Face lit : all_faces) {
        GridSetup setup{.shape = block, .lit_face = lit, .sides = sides, .source = source};
        const auto s = solver(setup);
        s->set_medium(c.kappa, c.mu);
        const Values light =
            testing::random_values(face_shape(block, lit).cells() * patterns, 0, 1, 6);
        const auto solution = testing::solve_light(*s, light, patterns, {tolerance, 100});
        ASSERT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
        std::array<Values, 6> maps;
        for (std::size_t f = 0; f < 6; ++f) {
          maps[f] = testing::exitance(*s, *solution.phi, all_faces[f], light);
        }
        for (const PowerBalance& b : power_balance(*s, medium, *solution.phi, light, maps)) {
          const double out =
              std::accumulate(b.exiting.begin(), b.exiting.end(), 0.0) + b.unscattered + b.absorbed;
          EXPECT_NEAR(out, b.entering, 10 * tolerance * b.entering) << to_string(lit);
        }
      }
    }
  }
}

TEST_P(GridLaws, FluenceObeysTheMaximumPrinciple) {
  constexpr double tolerance = 1e-8;
  GridSetup setup{.shape = block, .source = SourceModel::boundary};
  const auto s = solver(setup);
  const Coefficients c = testing::random_medium(block, 1000, 7);
  s->set_medium(c.kappa, c.mu);
  Values light(face_shape(block, setup.lit_face).cells(), 0.0);
  light[40] = 1.0;
  light[41] = 0.5;
  const auto solution = testing::solve_light(*s, light, 1, {tolerance, 100});
  const Values phi = testing::read(*s, *solution.phi);
  const double q = boundary_q_per_irradiance(setup, s->constants());
  const double slack = 10 * tolerance * q;
  EXPECT_GE(*std::min_element(phi.begin(), phi.end()), -slack);
  EXPECT_LE(*std::max_element(phi.begin(), phi.end()), q + slack);
}

/// <exitance(φ), w> = <φ, adjoint(w)> on every face, for the part linear in φ.
TEST_P(GridLaws, ExitanceAndItsAdjointAgree) {
  constexpr int patterns = 3;
  for (const Convention convention : {Convention::physical, Convention::wang2008}) {
    GridSetup setup{.shape = block, .source = SourceModel::boundary, .convention = convention};
    const auto s = solver(setup);
    const Coefficients c = testing::random_medium(block, 10, 8);
    s->set_medium(c.kappa, c.mu);
    const Values values = testing::random_values(block.cells() * patterns, 0, 1, 9);
    const auto phi = s->make_field(patterns), adjoint = s->make_field(patterns);
    s->fill(*phi, values);
    for (const Face face : all_faces) {
      const std::size_t samples = face_shape(block, face).cells() * patterns;
      const Values w = testing::random_values(samples, 0, 1, 10);
      const double left = dot(testing::exitance(*s, *phi, face, Values(samples, 0.0)), w);
      s->exitance_adjoint(face, w, *adjoint);
      const double right = dot(values, testing::read(*s, *adjoint));
      EXPECT_NEAR(left, right, rounding() * left) << to_string(face);
    }
  }
}

TEST_P(GridLaws, FirstCollisionsAndTheRestSumToTheBeam) {
  // Much is reflected: a fifth of what arrives.
  GridSetup setup{.shape = block, .eta = 2.6, .lit_face = Face::y_plus};
  const auto s = solver(setup);
  Coefficients c = testing::random_medium(block, 100, 11);
  for (double& k : c.kappa) k *= 5.0;
  for (double& m : c.mu) m /= 5.0;
  s->set_medium(c.kappa, c.mu);
  const FaceShape face = face_shape(block, setup.lit_face);
  Values light(face.cells(), 0.0);
  const int u = 3, v = 5;
  light[static_cast<std::size_t>(v) * face.nu + u] = 2.0;
  const auto b = s->make_field(1);
  s->light_source(light, *b);
  const Values source = testing::read(*s, *b);

  const double h = block.voxel_mm;
  const double power = s->constants().normal_transmittance * 2.0 * h * h;
  Values lost(static_cast<std::size_t>(block.ny), 0.0);
  double beam = power, unscattered = 0.0;
  for (int passage = 0; passage < 20; ++passage) {
    for (int k = 0; k < block.ny; ++k) {
      const int depth = passage % 2 == 0 ? k : block.ny - 1 - k;
      const std::size_t i = face_cell(block, setup.lit_face, u, v, depth);
      const double collides = beam * (1 - std::exp(-h / (3 * c.kappa[i])));
      lost[static_cast<std::size_t>(depth)] += collides;
      beam -= collides;
    }
    unscattered += (1 - fresnel_internal(setup.eta, 1)) * beam;
    beam *= fresnel_internal(setup.eta, 1);
  }
  double absorbed = 0.0;
  for (int depth = 0; depth < block.ny; ++depth) {
    const std::size_t i = face_cell(block, setup.lit_face, u, v, depth);
    const double albedo = std::max(0.0, 1 - 3 * c.kappa[i] * c.mu[i]);
    const double here = lost[static_cast<std::size_t>(depth)];
    EXPECT_NEAR(source[i], albedo * here, rounding() * power) << depth;
    absorbed += (1 - albedo) * here;
  }
  const double total = std::accumulate(source.begin(), source.end(), 0.0);
  EXPECT_NEAR(total + absorbed + unscattered, power, 10 * rounding() * power);
}

TEST_P(GridLaws, NothingScattersWhereAbsorptionTakesAll) {
  GridSetup setup{.shape = {2, 2, 3, 0.5}};
  const auto s = solver(setup);
  s->set_medium(Values(12, 1.0), Values(12, 0.5));  // 3κμ = 1.5
  const auto b = s->make_field(1);
  s->light_source(Values(4, 1.0), *b);
  EXPECT_EQ(testing::norm(testing::read(*s, *b)), 0.0);
  // A dark right-hand side is solved by zero, not by 0/0.
  const auto solution = testing::solve_light(*s, Values(4, 1.0), 1, {1e-8, 20});
  EXPECT_EQ(solution.report.termination, Termination::converged);
  EXPECT_EQ(testing::norm(testing::read(*s, *solution.phi)), 0.0);
}

/// Lengths in another unit: h and κ grow, μ falls, φ stays.
TEST_P(GridLaws, FluenceDoesNotDependOnTheUnitOfLength) {
  constexpr double unit = 8.0;
  const Coefficients c = testing::random_medium(block, 10, 12);
  Coefficients d = c;
  for (double& k : d.kappa) k *= unit;
  for (double& m : d.mu) m /= unit;
  GridShape scaled = block;
  scaled.voxel_mm *= unit;
  const Values light = testing::random_values(std::size_t{13} * 11, 0, 1, 13);
  const SolveOptions options{single() ? 1e-7 : 1e-11, 100};
  const auto a = solver({.shape = block});
  const auto b = solver({.shape = scaled});
  a->set_medium(c.kappa, c.mu);
  b->set_medium(d.kappa, d.mu);
  const auto one = testing::solve_light(*a, light, 1, options);
  const auto other = testing::solve_light(*b, light, 1, options);
  EXPECT_LT(
      testing::relative_difference(testing::read(*b, *other.phi), testing::read(*a, *one.phi)),
      10 * rounding());
}

TEST_P(GridLaws, EqualInputGivesEqualBits) {
  constexpr int patterns = 5;
  const Coefficients c = testing::random_medium(block, 100, 14);
  const Values light = testing::random_values(std::size_t{13} * 11 * patterns, 0, 1, 15);
  const auto run = [&] {
    const auto s = solver({.shape = block});
    s->set_medium(c.kappa, c.mu);
    const auto solution = testing::solve_light(*s, light, patterns, {1e-6, 100});
    return testing::read(*s, *solution.phi);
  };
  EXPECT_EQ(run(), run());
}

TEST_P(GridLaws, AGoodStartSavesIterations) {
  const auto s = solver({.shape = block});
  const Coefficients c = testing::random_medium(block, 10, 16);
  s->set_medium(c.kappa, c.mu);
  const Values light = testing::random_values(std::size_t{13} * 11, 0, 1, 17);
  auto solution = testing::solve_light(*s, light, 1, {1e-7, 100});
  const auto b = s->make_field(1);
  s->light_source(light, *b);
  const SolveReport again = s->solve(*b, *solution.phi, {1e-6, 100});
  EXPECT_EQ(again.iterations, 0);
  EXPECT_EQ(again.termination, Termination::converged);
}

TEST_P(GridLaws, RunningOutIsReportedNotHidden) {
  const auto s = solver({.shape = block});
  const Coefficients c = testing::random_medium(block, 1000, 18);
  s->set_medium(c.kappa, c.mu);
  const auto solution = testing::solve_light(
      *s, testing::random_values(std::size_t{13} * 11, 0, 1, 19), 1, {1e-6, 2});
  EXPECT_EQ(solution.report.termination, Termination::ran_out);
  EXPECT_GT(solution.report.residual[0], 1e-6);
  EXPECT_NE(solution.report.message.find("not met"), std::string::npos);
}

TEST_P(GridLaws, NotANumberIsAFailureNotAnAnswer) {
  const auto s = solver({.shape = {3, 3, 3, 1.0}});
  s->set_medium(Values(27, 0.3), Values(27, 0.01));
  Values rhs(27, 1.0);
  rhs[4] = std::nan("");
  const auto solution = testing::solve_rhs(*s, rhs, 1, {1e-6, 20});
  EXPECT_EQ(solution.report.termination, Termination::failed);
}

INSTANTIATE_TEST_SUITE_P(, GridLaws,
                         ::testing::Values(testing::reference_backend, testing::opencl_single,
                                           testing::opencl_double),
                         testing::backend_name);

}  // namespace
}  // namespace kappamu::forward
