// Laws and closed forms of the random walk in objects. Comparison with the walk in blocks is in
// object_monte_carlo_block_test.cpp.
#include "forward/montecarlo/object_monte_carlo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/optics.h"
#include "tests/render/object_tools.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

using testing::coefficients;
using ::testing::HasSubstr;
using testing::Object;
using testing::random_medium;

/// Of diffuse light, the share that enters.
double transmitted(double eta) {
  return eta * eta * (1.0 - boundary_constants(eta).r_phi);
}

/// Sums of 64-bit integers, turned into doubles at the end.
constexpr double exact = 1e-12;
/// Of a statistic against its expectation, in standard errors: 1 in 15000 by chance.
constexpr double sigmas = 4.0;

ObjectResult traced(const ObjectProblem& problem, std::uint64_t photons, bool follow = false,
                    std::uint64_t seed = 1) {
  ObjectOptions options;
  options.follow_reentry = follow;
  options.seed = seed;
  Progress silent;
  return make_object_model("montecarlo", ModelError::warned,
                           {{"photons", static_cast<double>(photons)}})
      ->solve(problem, options, silent);
}

double total(const Object& object, const ObjectResult& result,
             const Object::Where& where = Object::everywhere) {
  double sum = 0.0;
  for (std::size_t i = 0; i < object.surface.size(); ++i) {
    if (where(i)) sum += result.exitance[i] * object.surface.area[i];
  }
  return sum;
}

/// Of a sum of samples of one light; what leaves by one leaves by no other, so that it is less.
double error_of_total(const Object& object, const ObjectResult& result,
                      const Object::Where& where = Object::everywhere) {
  double sum = 0.0;
  for (std::size_t i = 0; i < object.surface.size(); ++i) {
    const double error = result.standard_error[i] * object.surface.area[i];
    if (where(i) && result.exitance[i] > 0.0) sum += error * error;
  }
  return std::sqrt(sum);
}

void expect_exitance(const Object& object, const ObjectResult& result, double expected) {
  double chi2 = 0.0;
  for (std::size_t i = 0; i < object.surface.size(); ++i) {
    const double apart = (result.exitance[i] - expected) / result.standard_error[i];
    chi2 += apart * apart;
  }
  const auto n = static_cast<double>(object.surface.size());
  EXPECT_NEAR(chi2 / n, 1.0, sigmas * std::sqrt(2.0 / n));
}

TEST(ObjectMonteCarlo, PowerBalancesExactly) {
  for (const char* shape : {"torus", "box-with-void", "split-cube", "spike", "sheet"}) {
    const Object object(make_shape(shape, 8.0, 12));
    const ObjectMedium medium = random_medium(object, coefficients(0.05, 2.0), 3.0);
    const std::vector<ObjectLight> lights{object.diffuse(),
                                          object.lambertian_beams(500, Object::everywhere, 2)};
    for (const bool follow : {false, true}) {
      const ObjectResult result = traced(object.problem(medium, 1.4, lights), 5000, follow);
      for (std::size_t m = 0; m < lights.size(); ++m) {
        const ObjectBalance& b = result.balance[m];
        EXPECT_NEAR(b.exiting + b.absorbed + b.unscattered, b.entering, exact * b.entering);
        EXPECT_GT(b.absorbed, 0.0);
        EXPECT_EQ(b.unscattered > 0.0, m == 1) << "only beams have light that never scattered";
      }
      EXPECT_NEAR(total(object, result), result.balance[0].exiting, exact * object.area());
      EXPECT_THAT(result.warnings, ::testing::IsEmpty()) << result.warnings.front();
    }
  }
}

TEST(ObjectMonteCarlo, NothingIsAbsorbedWhereMuIsZero) {
  const Object object(make_shape("torus", 8.0, 12));
  const ObjectMedium medium(coefficients(0.0, 2.0));
  const std::vector<ObjectLight> lights{object.diffuse()};
  const ObjectResult result = traced(object.problem(medium, 1.3, lights), 5000);
  EXPECT_EQ(result.balance[0].absorbed, 0.0);
  EXPECT_NEAR(result.balance[0].exiting, result.balance[0].entering,
              exact * result.balance[0].entering);
  EXPECT_NEAR(result.balance[0].entering, transmitted(1.3) * object.area(), exact * object.area());
}

// Photons are independent of each other and of who follows them.
TEST(ObjectMonteCarlo, EqualSeedsGiveEqualBits) {
  const Object object(make_shape("split-cube", 4.0, 6));
  const ObjectMedium medium = random_medium(object, coefficients(0.05, 2.0), 3.0);
  const std::vector<ObjectLight> lights{object.diffuse(), object.diffuse()};
  const ObjectProblem problem = object.problem(medium, 1.3, lights);
  const ObjectResult one = traced(problem, 20000, true), two = traced(problem, 20000, true);
  EXPECT_EQ(one.exitance, two.exitance);
  EXPECT_EQ(one.standard_error, two.standard_error);
  EXPECT_NE(one.exitance, traced(problem, 20000, true, 2).exitance);
  const std::size_t n = object.surface.size();
  EXPECT_FALSE(std::equal(one.exitance.begin(), one.exitance.begin() + static_cast<long>(n),
                          one.exitance.begin() + static_cast<long>(n)))
      << "two lights share their photons";
}

// Size and coefficients together: by a power of two not a bit changes.
TEST(ObjectMonteCarlo, IsIndependentOfUnits) {
  const Object small(make_shape("torus", 4.0, 8)), large(make_shape("torus", 16.0, 8));
  const ObjectMedium dense(coefficients(0.4, 8.0)), thin(coefficients(0.1, 2.0));
  const std::vector<ObjectLight> lights{small.diffuse()};
  EXPECT_EQ(traced(small.problem(dense, 1.3, lights), 5000).exitance,
            traced(large.problem(thin, 1.3, lights), 5000).exitance);
}

// Detailed balance: in uniform diffuse light a body that absorbs nothing has the radiance of its
// surroundings everywhere (times η² inside), whatever its shape and scattering.
TEST(ObjectMonteCarlo, UniformLightComesOutAsItWentIn) {
  for (const char* shape : {"torus", "slab", "spike"}) {
    const Object object(make_shape(shape, 6.0, 8));
    const ObjectMedium medium = random_medium(object, coefficients(0.0, 1.0), 4.0);
    const std::vector<ObjectLight> lights{object.diffuse()};
    for (const double eta : {1.0, 1.4}) {
      SCOPED_TRACE(shape + std::to_string(eta));
      expect_exitance(object, traced(object.problem(medium, eta, lights), 100'000),
                      transmitted(eta));
    }
  }
}

// The same of a void that no light reaches but through the body: followed, its walls shine as
// brightly as the outside; not followed, what leaves into it is what would meet the body again.
TEST(ObjectMonteCarlo, LightThatMeetsTheObjectAgainIsFollowedOrCounted) {
  const Object object(make_shape("box-with-void", 4.0, 6));
  const auto in_void = [&](std::size_t i) {
    return object.surface.position[i].cwiseAbs().maxCoeff() < 1.5;
  };
  const auto outside = [&](std::size_t i) { return !in_void(i); };
  const ObjectMedium medium(coefficients(0.0, 1.5));
  const std::vector<ObjectLight> lights{object.diffuse(outside)};
  for (const double eta : {1.0, 1.3}) {
    const ObjectProblem problem = object.problem(medium, eta, lights);
    const double entering = transmitted(eta) * object.area(outside);
    const ObjectResult followed = traced(problem, 100'000, true);
    expect_exitance(object, followed, transmitted(eta));
    const ObjectBalance& b = followed.balance[0];
    EXPECT_NEAR(total(object, followed, in_void), b.reentering, exact * b.entering);
    EXPECT_NEAR(b.exiting, b.entering, exact * b.entering);
    // In the void light is reflected until it enters: all of it does.
    EXPECT_NEAR(b.entering, entering + b.reentering, exact * b.entering);

    const ObjectResult counted = traced(problem, 100'000, false);
    EXPECT_NEAR(counted.balance[0].entering, entering, exact * entering);
    EXPECT_NEAR(total(object, counted, in_void), counted.balance[0].reentering, exact * entering);
  }
}

// From one part to another and back, for true Lambertian light outside: through a rough medium and
// refraction, with absorption.
TEST(ObjectMonteCarlo, IsReciprocal) {
  const Object object(make_shape("torus", 5.0, 16));
  const ObjectMedium medium = random_medium(object, coefficients(0.05, 1.0), 3.0);
  const auto low = [&](std::size_t i) {
    return object.surface.position[i].x() > 1.0 && object.surface.position[i].z() < -0.2;
  };
  const auto inner = [&](std::size_t i) {
    return object.surface.position[i].x() > 0.0 &&
           object.surface.position[i].head<2>().norm() < 1.5;
  };
  for (const double eta : {1.0, 1.4}) {
    const std::vector<ObjectLight> there{object.lambertian_beams(50'000, low, 1)};
    const std::vector<ObjectLight> back{object.lambertian_beams(50'000, inner, 2)};
    const ObjectResult to = traced(object.problem(medium, eta, there), 150'000, true);
    const ObjectResult from = traced(object.problem(medium, eta, back), 150'000, true);
    const double one = total(object, to, inner), other = total(object, from, low);
    const double error =
        std::hypot(error_of_total(object, to, inner), error_of_total(object, from, low));
    EXPECT_NEAR(one, other, sigmas * error);
    EXPECT_LT(error, 0.05 * one);
  }
}

// A sphere that absorbs and does not scatter, in diffuse light: of chords of length l there are
// l/(2R²) dl, so that (1 − (1+2μR)e^(−2μR))/(2μ²R²) comes through.
TEST(ObjectMonteCarlo, AnAbsorbingSphereFollowsTheChords) {
  const Object object(sphere_mesh(1.0, 60));
  for (const double mu : {0.3, 1.0, 3.0}) {
    const ObjectMedium medium(Coefficients{1.0 / (3.0 * mu), mu});
    const std::vector<ObjectLight> lights{object.diffuse()};
    constexpr double photons = 100'000;
    const ObjectResult result =
        traced(object.problem(medium, 1.0, lights), static_cast<std::uint64_t>(photons));
    const double expected = (1.0 - (1.0 + 2.0 * mu) * std::exp(-2.0 * mu)) / (2.0 * mu * mu);
    const double faceted = 2e-3;  // the mesh is that much less than the sphere
    EXPECT_NEAR(total(object, result) / object.area(), expected,
                sigmas * std::sqrt(expected / photons) + faceted * expected);
  }
}

// Where diffusion holds: a sphere of 50 mean free paths in diffuse light has φ = C sinh(r/L)/r with
// φ + 2Aκφ' = 4E_t/(1−R_φ) at its surface, and absorbs 4πR²κφ'(R).
TEST(ObjectMonteCarlo, AThickSphereDiffuses) {
  constexpr double radius = 5.0, eta = 1.3;
  const Object object(sphere_mesh(radius, 40));
  const Coefficients c = coefficients(0.02, 10.0);
  const ObjectMedium medium(c);
  const std::vector<ObjectLight> lights{object.diffuse()};
  const ObjectResult result = traced(object.problem(medium, eta, lights), 30'000);
  const BoundaryConstants boundary = boundary_constants(eta);
  const double x = radius / std::sqrt(c.kappa / c.mu);
  const double slope = (x / std::tanh(x) - 1.0) / radius;  // φ'/φ
  const double fluence =
      4.0 * transmitted(eta) / (1.0 - boundary.r_phi) / (1.0 + 2.0 * boundary.A * c.kappa * slope);
  const double absorbed = 4.0 * std::numbers::pi * radius * radius * c.kappa * slope * fluence;
  constexpr double diffusion_error = 0.02;
  EXPECT_NEAR(result.balance[0].absorbed, absorbed, diffusion_error * absorbed);
}

// Predicted against the spread of repeated runs, sample by sample; light that comes back may leave
// a sample twice.
TEST(ObjectMonteCarlo, StandardErrorsAreTrue) {
  const Object object(make_shape("split-cube", 3.0, 2));
  const ObjectMedium medium(coefficients(0.1, 2.0));
  const std::vector<ObjectLight> lights{object.diffuse()};
  constexpr int runs = 200;
  std::vector<double> sum(object.surface.size()), square(sum.size()), predicted(sum.size());
  for (int run = 0; run < runs; ++run) {
    const ObjectResult result =
        traced(object.problem(medium, 1.3, lights), 4000, true, static_cast<std::uint64_t>(run));
    for (std::size_t i = 0; i < sum.size(); ++i) {
      sum[i] += result.exitance[i];
      square[i] += result.exitance[i] * result.exitance[i];
      predicted[i] += result.standard_error[i] * result.standard_error[i] / runs;
    }
  }
  double ratio = 0.0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    ratio += (square[i] - sum[i] * sum[i] / runs) / (runs - 1) / predicted[i];
  }
  const auto n = static_cast<double>(sum.size());
  EXPECT_NEAR(ratio / n, 1.0, sigmas * std::sqrt(2.0 / (n * runs)));
}

TEST(ObjectMonteCarlo, TheStatedNoiseDoesNotDependOnTriangles) {
  const ObjectMedium medium(coefficients(0.1, 2.0));
  const auto stated = [&](int edges) {
    const Object object(make_shape("sphere", 3.0, edges));
    const std::vector<ObjectLight> lights{object.diffuse()};
    return traced(object.problem(medium, 1.3, lights), 40'000).error_estimate[0];
  };
  EXPECT_NEAR(stated(64) / stated(24), 1.0, 0.1);
}

TEST(ObjectMonteCarlo, WhatCannotBeFollowedIsRefused) {
  const Object object(make_shape("cube", 2.0, 1));
  const ObjectMedium fine(coefficients(0.1, 1.0)), black(Coefficients{1.0, 0.5});
  std::vector<ObjectLight> lights{object.diffuse()};
  EXPECT_THAT(sentence_of([&] { traced(object.problem(black, 1.3, lights), 100); }),
              HasSubstr("3 kappa mu > 1"));
  EXPECT_THAT(sentence_of([&] { traced(object.problem(fine, 1.3, lights), 1); }),
              HasSubstr("photons must lie in [2, "));
  EXPECT_THAT(sentence_of([&] { traced(object.problem(fine, 0.5, lights), 100); }),
              HasSubstr("eta"));
  lights[0].diffuse[3] = -1.0;
  EXPECT_THAT(sentence_of([&] { traced(object.problem(fine, 1.3, lights), 100); }),
              HasSubstr("light 0 has the diffuse irradiance -1"));
  lights[0] = object.lambertian_beams(1, Object::everywhere, 1);
  lights[0].beams[0].direction *= -1.0;
  EXPECT_THAT(sentence_of([&] { traced(object.problem(fine, 1.3, lights), 100); }),
              HasSubstr("from inside"));
}

}  // namespace
}  // namespace kappamu::forward
