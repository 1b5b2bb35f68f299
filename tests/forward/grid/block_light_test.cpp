// Oblique beams and points inside a block, by grid diffusion: closed forms of half-spaces, balance
// of power, and what is refused.
#include "forward/grid/block_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "forward/forward_model.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

ForwardProblem block(const GridShape& shape, double kappa, double mu) {
  ForwardProblem problem;
  problem.setup.shape = shape;
  problem.medium = {Volume<double>(shape, kappa), Volume<double>(shape, mu)};
  problem.irradiance.assign(face_shape(shape, Face::z_minus).cells(), 0.0);
  return problem;
}

ForwardResult solve(const ForwardProblem& problem) {
  ForwardOptions options;
  options.fluence = true;
  options.solve.tolerance = 1e-9;
  Progress silent;
  return make_forward_model("reference")->solve(problem, options, silent);
}

double out_of(const PowerBalance& balance) {
  double sum = balance.absorbed + balance.unscattered;
  for (const double power : balance.exiting) sum += power;
  return sum;
}

/// φ of a point of unit power at depth z0 in a half-space, on its axis' distance rho and depth z:
/// point, image, and a line of images behind it (Bryan 1890 for φ − z_b ∂φ/∂z = 0).
double half_space(double kappa, double mu, double A, double rho, double z, double z0) {
  const double decay = std::sqrt(mu / kappa), zb = 2.0 * A * kappa;
  const auto point = [&](double along) {
    const double r = std::hypot(rho, along);
    return std::exp(-decay * r) / (4.0 * std::numbers::pi * kappa * r);
  };
  double line = 0.0;
  constexpr int steps = 4000;
  const double longest = 20.0 * zb, step = longest / steps;
  for (int i = 0; i < steps; ++i) {
    const double s = (i + 0.5) * step;
    line += std::exp(-s / zb) * point(z + z0 + s) * step;
  }
  return point(z - z0) + point(z + z0) - 2.0 / zb * line;
}

// The far faces are 7 decay lengths away. What is left is the grid's error, of order h².
TEST(BlockLight, APointBelowAFaceIsThatOfTheHalfSpace) {
  const double kappa = 0.4, mu = 0.05;
  const GridShape shape{40, 40, 30, 0.5};
  ForwardProblem problem = block(shape, kappa, mu);
  const Vector3d at(10.25, 10.25, 3.25);  // a voxel's centre
  problem.light.points = {{at, 2.0}};
  const ForwardResult result = solve(problem);
  const double A = boundary_constants(problem.setup.eta).A;
  for (const int x : {20, 24, 28, 32}) {
    for (const int z : {0, 2, 6, 10, 14}) {
      const double rho = (x + 0.5) * 0.5 - at.x(), depth = (z + 0.5) * 0.5;
      if (std::hypot(rho, depth - at.z()) < 1.9) continue;  // four voxels
      const double expected = 2.0 * half_space(kappa, mu, A, rho, depth, at.z());
      const double found = result.fluence[shape.index(x, 20, z)];
      const double r = std::hypot(rho, depth - at.z());
      const double grid_error = 0.01 + 0.7 * std::pow(shape.voxel_mm / r, 2);
      EXPECT_NEAR(found / expected, 1.0, grid_error) << x << ' ' << z;
    }
  }
  EXPECT_DOUBLE_EQ(result.balance[0].entering, 2.0);
  EXPECT_NEAR(out_of(result.balance[0]), 2.0, 1e-6);
}

TEST(BlockLight, APointBetweenVoxelsKeepsItsPlace) {
  const GridShape shape{12, 10, 8, 0.5};
  ForwardProblem problem = block(shape, 0.3, 0.02);
  const Vector3d at(2.1, 2.9, 1.37);
  problem.light.points = {{at, 1.5}};
  const LightLoad load =
      light_load(problem.setup, problem.medium, problem.light, problem.irradiance, 1);
  double power = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (int z = 0; z < shape.nz; ++z)
    for (int y = 0; y < shape.ny; ++y)
      for (int x = 0; x < shape.nx; ++x) {
        const double share = load.source[shape.index(x, y, z)];
        power += share;
        moment += share * 0.5 * (Vector3d(x, y, z) + Vector3d::Constant(0.5));
      }
  EXPECT_NEAR(power, 1.5, 1e-12);
  EXPECT_LT((moment / power - at).norm(), 1e-12);
}

// Between mirrors an even beam makes φ = B e^(−z/δ) + C e^(−z σt/cos θ').
TEST(BlockLight, AnEvenObliqueBeamIsThatOfTheHalfSpace) {
  const double kappa = 0.4, mu = 0.05, eta = 1.4, h = 0.05;
  ForwardProblem problem = block({2, 2, 500, h}, kappa, mu);
  problem.setup.eta = eta;
  problem.setup.sides = Sides::mirror;
  problem.irradiance.assign(4, 3.0);
  problem.light.direction = Vector3d(std::sin(1.0), 0.0, std::cos(1.0));
  const ForwardResult result = solve(problem);
  const double transmitted = 1.0 - fresnel_external(eta, std::cos(1.0));
  const double cosine = std::sqrt(1.0 - std::pow(std::sin(1.0) / eta, 2));
  const double extinction = 1.0 / (3.0 * kappa), a = extinction / cosine;
  const double decay = std::sqrt(mu / kappa);
  const double zb = 2.0 * boundary_constants(eta).A * kappa;
  const double first = 3.0 * transmitted * (extinction - mu) / cosine;
  const double c = first / (mu - kappa * a * a);
  const double b = -c * (1.0 + zb * a) / (1.0 + zb * decay);
  for (const int z : {0, 20, 60, 150, 300}) {
    const double depth = (z + 0.5) * h;
    const double expected = b * std::exp(-decay * depth) + c * std::exp(-a * depth);
    constexpr double grid_error = 1e-3;  // a third of (h/3κ)², with room
    EXPECT_NEAR(result.fluence[problem.setup.shape.index(0, 0, z)] / expected, 1.0, grid_error)
        << z;
  }
  const PowerBalance& balance = result.balance[0];
  EXPECT_NEAR(balance.entering, 3.0 * transmitted * 4.0 * h * h, 1e-12);
  EXPECT_NEAR(out_of(balance) / balance.entering, 1.0, 1e-6);
}

// Every face lit, from a slant: what does not scatter is reflected about until it is gone.
TEST(BlockLight, ObliqueLightBalances) {
  for (const Face face : all_faces) {
    for (const Sides sides : {Sides::open, Sides::mirror}) {
      ForwardProblem problem = block({6, 5, 4, 0.4}, 0.8, 0.01);
      problem.setup.lit_face = face;
      problem.setup.sides = sides;
      const std::size_t pixels = face_shape(problem.setup.shape, face).cells();
      problem.patterns = 3;
      problem.irradiance.assign(3 * pixels, 0.0);
      for (std::size_t k = 0; k < pixels; ++k) problem.irradiance[k] = 1.0;
      problem.irradiance[pixels + 3] = 2.0;
      problem.light.points = {{{1.0, 1.0, 0.7}, 1.0}};
      Vector3d direction(0.7, -0.6, 0.5);
      direction[axis_of(face)] = is_plus(face) ? -0.8 : 0.8;
      problem.light.direction = direction;
      const ForwardResult result = solve(problem);
      for (const PowerBalance& balance : result.balance) {
        EXPECT_GT(balance.entering, 0.0);
        EXPECT_NEAR(out_of(balance) / balance.entering, 1.0, 1e-6) << to_string(face);
      }
      EXPECT_GT(result.balance[0].unscattered, 0.0);
      EXPECT_EQ(result.balance[2].unscattered, 0.0);
    }
  }
}

// One column's series and the march of its rays: the thin block sends back a tenth of its light.
TEST(BlockLight, NormalIncidenceIsTheLimitOfOblique) {
  for (const GridShape& shape : {GridShape{6, 5, 40, 0.4}, GridShape{6, 5, 2, 0.4}}) {
    ForwardProblem problem = block(shape, 0.5, 0.01);
    problem.setup.eta = 2.4;
    problem.irradiance[9] = 1.0;
    const ForwardResult normal = solve(problem);
    problem.light.direction = Vector3d(0.0, 0.0, 2.0);
    const ForwardResult along = solve(problem);
    const PowerBalance &a = normal.balance[0], &b = along.balance[0];
    EXPECT_NEAR(b.entering, a.entering, 1e-12);
    EXPECT_NEAR(b.unscattered, a.unscattered, 1e-8 * a.entering);
    EXPECT_NEAR(b.absorbed, a.absorbed, 1e-6 * a.entering);
    for (std::size_t i = 0; i < normal.fluence.size(); ++i)
      EXPECT_NEAR(along.fluence[i], normal.fluence[i], 1e-6 * normal.fluence[9]) << i;
  }
}

TEST(BlockLight, RefusesLightThatIsNone) {
  ForwardProblem problem = block({6, 5, 4, 0.4}, 0.2, 0.01);
  const auto refused = [&](const LightGeometry& light, const char* what) {
    problem.light = light;
    EXPECT_THAT(sentence_of([&] { solve(problem); }), HasSubstr(what));
  };
  refused({Vector3d(1, 0, 0), {}}, "does not lead into the lit face z-");
  refused({Vector3d(0, 0, -1), {}}, "does not lead into the lit face z-");
  refused({Vector3d(0, 0, std::nan("")), {}}, "does not lead into the lit face z-");
  refused({{}, {{{1, 1, 1.6}, 1.0}}}, "does not lie inside the block");
  refused({{}, {{{1, std::nan(""), 1}, 1.0}}}, "does not lie inside the block");
  refused({{}, {{{1, 1, 1}, 0.0}}}, "must be positive");
  refused({{}, {{{1, 1, 1}, 1.0}, {{1, 1, 1}, 1.0}}}, "more points than patterns");
  problem.setup.source = SourceModel::boundary;
  refused({Vector3d(0, 0, 1), {}}, "first-collision source only");
}

TEST(BlockLight, OtherMethodsRefuseIt) {
  ForwardProblem problem = block({4, 4, 4, 0.4}, 0.2, 0.01);
  problem.setup.sides = Sides::mirror;
  Progress silent;
  for (const MethodName& method : forward_methods()) {
    if (method.any_light) continue;
    const auto model = make_forward_model(method.name);
    ForwardOptions options;
    options.fluence = true;
    EXPECT_THAT(sentence_of([&] { model->solve(problem, options, silent); }),
                HasSubstr("'" + method.name + "' does not give the fluence"));
    ForwardProblem slanted = problem;
    slanted.light.direction = Vector3d(0, 0.2, 1);
    EXPECT_THAT(sentence_of([&] { model->solve(slanted, {}, silent); }),
                HasSubstr("'" + method.name + "' takes neither oblique light nor points"));
  }
}

}  // namespace
}  // namespace kappamu::forward
