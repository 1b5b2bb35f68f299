// The model from lights to exitance: its own error estimate, and the laws that hold whatever the
// object. Iterations and orders: embedded_multigrid_test, embedded_order_test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/error.h"
#include "embedded_test_tools.h"
#include "exact_sphere.h"
#include "forward/embedded/discretisation.h"
#include "forward/embedded/embedded_model.h"
#include "forward/embedded/solver_choice.h"
#include "forward/light_entry.h"
#include "tests/forward/lit_object.h"

namespace kappamu::forward::embedded {
namespace {

constexpr double eta = 1.3;
const Coefficients wax{0.3, 0.01};

using Values = std::vector<double>;

ObjectResult solve_object(const TriangleMesh& mesh, const ObjectMedium& medium,
                          const std::vector<ObjectLight>& lights, double tolerance = 0.02) {
  const Surface surface = surface_of(mesh);
  const auto rays = make_caster(mesh);
  Progress progress;
  ObjectOptions options;
  options.tolerance = tolerance;
  return EmbeddedModel().solve({mesh, surface, *rays, medium, eta, lights}, options, progress);
}

double norm(const Surface& surface, const Values& a) {
  double sum = 0.0;
  for (std::size_t t = 0; t < a.size(); ++t) sum += surface.area[t] * a[t] * a[t];
  return std::sqrt(sum);
}

double relative_difference(const TriangleMesh& mesh, const Values& a, const Values& b) {
  const Surface surface = surface_of(mesh);
  Values difference(a.size());
  for (std::size_t t = 0; t < a.size(); ++t) difference[t] = a[t] - b[t];
  return norm(surface, difference) / norm(surface, b);
}

TEST(EmbeddedModel, AgreesWithTheExactSphere) {
  const TriangleMesh mesh = icosphere(5.0, 5, {0.1, 0.2, 0.3});
  const Surface surface = surface_of(mesh);
  const BoundaryConstants constants = boundary_constants(eta);
  const ExactSphere sphere{5.0, wax, constants.A};
  const ObjectLight light = sky(mesh);
  Values exact;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const double entering = diffuse_transmittance(constants);
    const double q = 4.0 * entering / (1.0 - constants.r_phi);
    const double z = surface.normal[t].z();
    const double phi =
        q * (0.5 * sphere.lit_from_outside(0) + 0.5 * z * sphere.lit_from_outside(1));
    exact.push_back((phi - q * light.diffuse[t]) / (2.0 * constants.A) +
                    entering * light.diffuse[t]);
  }
  // The faceted sphere's own difference from the round one, four times smaller than with a quarter
  // of the triangles.
  constexpr double facets = 1.2e-3;
  const ObjectResult result = solve_object(mesh, ObjectMedium(wax), {light});
  EXPECT_TRUE(result.converged) << result.message;
  EXPECT_LE(relative_difference(mesh, result.exitance, exact), result.error_estimate[0] + facets);
}

TEST(EmbeddedModel, StatesItsErrorUnderAPatchOfLight) {
  // A patch's edges are what light can be roughest at; what a tenfold tolerance leaves is the
  // error.
  const TriangleMesh mesh = icosphere(5.0, 3, {0.1, 0.2, 0.3});
  ObjectLight patch;
  for (const Eigen::Vector3d& normal : surface_of(mesh).normal) {
    patch.diffuse.push_back(normal.z() > 0.8 ? 1.0 : 0.0);
  }
  const ObjectMedium medium(Coefficients{0.1, 0.05});
  const ObjectResult coarse = solve_object(mesh, medium, {patch}, 0.05);
  const ObjectResult fine = solve_object(mesh, medium, {patch}, 0.005);
  EXPECT_TRUE(coarse.converged);
  EXPECT_TRUE(fine.converged);
  EXPECT_GT(fine.elements, coarse.elements);
  EXPECT_LE(relative_difference(mesh, coarse.exitance, fine.exitance),
            coarse.error_estimate[0] + fine.error_estimate[0]);
}

TEST(EmbeddedModel, BalancesPower) {
  // Beams and diffuse light together; a medium thin enough that light also passes unscattered.
  const TriangleMesh mesh = icosphere(2.0, 4, {0.0, 0.0, 0.0});
  ObjectLight both = sun(mesh);
  both.diffuse = sky(mesh).diffuse;
  const ObjectResult result =
      solve_object(mesh, ObjectMedium(Coefficients{1.0, 0.05}), {both, sun(mesh)});
  for (const ObjectBalance& balance : result.balance) {
    EXPECT_GT(balance.unscattered, 0.1 * balance.entering);
    EXPECT_NEAR((balance.unscattered + balance.exiting + balance.absorbed) / balance.entering, 1.0,
                1e-6);
  }
}

TEST(EmbeddedModel, BeamsLeaveTheirPowerByBeerAndLambert) {
  // Through a slab along its normal: e^−d/(3κ) passes, the rest divides as σs' to μ.
  const TriangleMesh mesh = box({10.0, 10.0, 2.0}, 4);
  const double kappa = 0.5, mu = 0.1;
  ObjectLight light;
  const Surface surface = surface_of(mesh);
  for (std::size_t t = 0; t < surface.size(); ++t) {
    if (surface.normal[t].z() > 0.5) {
      light.beams.push_back(
          {static_cast<int>(t), surface.position[t], -Eigen::Vector3d::UnitZ(), 1.0});
    }
  }
  const std::vector<ObjectLight> lights{light};
  const auto rays = make_caster(mesh);
  const ObjectMedium medium(Coefficients{kappa, mu});
  Octree tree(mesh);
  tree.refine_surface(4);
  CutMesh cut = cut_mesh(tree, mesh, *rays);
  const std::array media{&medium};
  const Discretisation d(std::move(tree), std::move(cut), media, boundary_constants(eta).A);
  Values load(d.levels.unknowns(), 0.0);
  ObjectBalance powers;
  std::vector<Beam> leaving;
  const std::array alike{ChannelBeams{&d.coefficients[0], &light.beams, &load, &powers, &leaving}};
  const MeshWalls walls({mesh, surface, *rays, medium, eta, lights});
  BeamPaths paths(walls, light.beams);
  add_beams(d.tree, d.mesh, d.space(), paths, alike);
  const double scattered = std::accumulate(load.begin(), load.end(), 0.0);
  // To and fro: of what arrives at a face 1 − R leaves.
  const double passed = std::exp(-2.0 / (3.0 * kappa));
  const double entering =
      static_cast<double>(light.beams.size()) * (1.0 - fresnel_external(eta, 1.0));
  const double reflected = fresnel_internal(eta, 1.0);
  const double unscattered = entering * (1.0 - reflected) * passed / (1.0 - reflected * passed);
  constexpr double rounding = 1e-9;
  EXPECT_NEAR(powers.entering, entering, rounding * entering);
  EXPECT_NEAR(powers.unscattered, unscattered, 1e-6 * entering);
  EXPECT_NEAR(powers.absorbed, (entering - unscattered) * 3.0 * kappa * mu, 1e-6 * entering);
  EXPECT_NEAR(scattered + powers.absorbed + powers.unscattered, entering, rounding * entering);
}

TEST(EmbeddedModel, LinearSystemsLeaveATenthOfTheToleranceAtMost) {
  const TriangleMesh mesh = icosphere(5.0, 4, {0.1, 0.2, 0.3});
  const Surface surface = surface_of(mesh);
  const std::vector<ObjectLight> lights{sky(mesh), sun(mesh)};
  const auto rays = make_caster(mesh);
  const ObjectMedium medium(wax);
  const ObjectProblem problem{mesh, surface, *rays, medium, eta, lights};
  const Channels channels(std::span(&problem, 1));
  Octree tree(mesh);
  tree.refine_surface(5);
  CutMesh cut = cut_mesh(tree, mesh, *rays);
  const Discretisation d(std::move(tree), std::move(cut), channels.media(), channels.constants.A);
  const auto exitance = [&](double left) {
    const auto solver = make_linear_solver(d.levels, channels.lights(), "reference");
    return answers(d, channels, *solver, left).channel[0].exitance;
  };
  const auto solved = exitance(1e-9);
  for (const double tolerance : {0.05, 0.005, 0.0005}) {
    const auto left = exitance(linear_tolerance(tolerance));
    for (std::size_t l = 0; l < lights.size(); ++l) {
      EXPECT_LE(relative_difference(mesh, left[l], solved[l]), 0.1 * tolerance) << tolerance;
    }
  }
}

TEST(EmbeddedModel, IsReciprocal) {
  // Diffuse light on one triangle seen at another, and the other way round.
  const TriangleMesh mesh = transformed(
      box({8.0, 5.0, 3.0}, 4), Eigen::Affine3d(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX())));
  const Surface surface = surface_of(mesh);
  const std::size_t a = 3, b = 100;
  std::vector<ObjectLight> lights(2);
  for (ObjectLight& light : lights) light.diffuse.assign(surface.size(), 0.0);
  lights[0].diffuse[a] = 1.0 / surface.area[a];
  lights[1].diffuse[b] = 1.0 / surface.area[b];
  const ObjectResult result = solve_object(mesh, ObjectMedium(wax), lights, 0.2);
  const double there = result.exitance[b], back = result.exitance[surface.size() + a];
  EXPECT_GT(there, 0.0);
  EXPECT_NEAR(there / back, 1.0, 1e-3);  // solver tolerance over the share of light that arrives
}

TEST(EmbeddedModel, TurningAndMovingTheObjectStaysWithinTheError) {
  const TriangleMesh mesh = box({10.0, 7.0, 5.0}, 8);
  const std::vector<ObjectLight> lights{sky(mesh)};
  const ObjectResult still = solve_object(mesh, ObjectMedium(wax), lights, 0.01);
  Eigen::Affine3d by = Eigen::Affine3d::Identity();
  by.rotate(Eigen::AngleAxisd(0.6, Eigen::Vector3d(3, 1, 2).normalized()));
  by.translate(Eigen::Vector3d(0.37, -0.21, 0.11));
  const ObjectResult turned = solve_object(transformed(mesh, by), ObjectMedium(wax), lights, 0.01);
  EXPECT_LE(relative_difference(mesh, turned.exitance, still.exitance),
            still.error_estimate[0] + turned.error_estimate[0]);
}

TEST(EmbeddedModel, DoesNotDependOnTheTessellation) {
  // Edges halved and doubled. Triangle t of a sphere became 4 t to 4 t + 3 of the next finer one.
  std::vector<Values> exitance;
  for (const int level : {4, 5, 6}) {
    const TriangleMesh mesh = icosphere(5.0, level, {0.1, 0.2, 0.3});
    exitance.push_back(solve_object(mesh, ObjectMedium(wax), {sky(mesh)}, 0.01).exitance);
  }
  const auto of_fours = [](const Values& fine) {
    Values mean(fine.size() / 4, 0.0);
    for (std::size_t t = 0; t < fine.size(); ++t) mean[t / 4] += fine[t] / 4.0;
    return mean;
  };
  constexpr double half_a_percent = 0.005;
  const TriangleMesh coarse = icosphere(5.0, 4, {0.1, 0.2, 0.3});
  const TriangleMesh middle = icosphere(5.0, 5, {0.1, 0.2, 0.3});
  EXPECT_LE(relative_difference(coarse, exitance[0], of_fours(exitance[1])), half_a_percent);
  EXPECT_LE(relative_difference(middle, of_fours(exitance[2]), exitance[1]), half_a_percent);
}

TEST(EmbeddedModel, ScalingObjectAndCoefficientsTogetherChangesNothing) {
  const TriangleMesh mesh = icosphere(2.0, 3, {0.1, 0.2, 0.3});
  const TriangleMesh large = transformed(mesh, Eigen::Affine3d(Eigen::Scaling(3.0)));
  const ObjectResult a = solve_object(mesh, ObjectMedium(wax), {sun(mesh)});
  const ObjectResult b =
      solve_object(large, ObjectMedium({3.0 * wax.kappa, wax.mu / 3.0}), {sun(large)});
  EXPECT_LE(relative_difference(mesh, b.exitance, a.exitance), 1e-5);
  EXPECT_EQ(a.elements, b.elements);
}

TEST(EmbeddedModel, BodiesAcrossAGapDoNotExchangeLight) {
  // Two cubes 1 µm apart: each is as it would be alone, and the unlit one stays dark.
  const TriangleMesh one = box({5.0, 5.0, 5.0}, 4);
  Eigen::Affine3d aside = Eigen::Affine3d::Identity();
  aside.translate(Eigen::Vector3d(5.001, 0.0, 0.0));
  const TriangleMesh both = joined(one, transformed(one, aside));
  ObjectLight light = sky(one);
  const ObjectResult alone = solve_object(one, ObjectMedium(wax), {light});
  light.diffuse.resize(both.triangles.size(), 0.0);
  const ObjectResult together = solve_object(both, ObjectMedium(wax), {light});
  for (std::size_t t = 0; t < one.triangles.size(); ++t) {
    ASSERT_NEAR(together.exitance[t], alone.exitance[t], 1e-9);
    ASSERT_EQ(together.exitance[one.triangles.size() + t], 0.0);
  }
}

TEST(EmbeddedModel, BridgedSlitsAreReported) {
  // One body with a slit of 1 µm: a box with a thin void.
  Eigen::Affine3d inside = Eigen::Affine3d::Identity();
  inside.translate(Eigen::Vector3d(0.5, 0.5, 2.5));
  const TriangleMesh mesh =
      joined(box({5.0, 5.0, 5.0}, 4), transformed(box({4.0, 4.0, 0.001}, 4), inside), true);
  const ObjectResult result = solve_object(mesh, ObjectMedium(wax), {sky(mesh)}, 0.1);
  EXPECT_THAT(result.warnings, testing::Contains(testing::HasSubstr(
                                   "% of the surface lies in slits narrower than its cubes")));
}

/// A sheet rolled up twice about the z axis: walls face each other across a gap [mm].
TriangleMesh roll(double thickness, double gap, double height) {
  constexpr int steps = 96, turns = 2;
  TriangleMesh mesh;
  for (int k = 0; k <= turns * steps; ++k) {
    const double angle = 2.0 * M_PI * k / steps;
    const double inner = 2.0 + (thickness + gap) * angle / (2.0 * M_PI);
    for (const double radius : {inner, inner + thickness}) {
      for (const double z : {0.0, height}) {
        mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
      }
    }
  }
  const auto face = [&](int a, int b, int c, int d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  // Corners of a section: inner low, inner high, outer low, outer high.
  for (int k = 0; k < 4 * turns * steps; k += 4) {
    face(k, k + 1, k + 5, k + 4);
    face(k + 2, k + 6, k + 7, k + 3);
    face(k, k + 4, k + 6, k + 2);
    face(k + 1, k + 3, k + 7, k + 5);
  }
  const int last = 4 * turns * steps;
  face(0, 2, 3, 1);
  face(last, last + 1, last + 3, last + 2);
  return mesh;
}

TEST(EmbeddedModel, ASheetRolledUpWithNarrowGapsIsResolved) {
  // First meshes bridge the gap alike, so that their difference states little of the error.
  const TriangleMesh mesh = roll(0.4, 0.15, 3.0);
  ASSERT_GT(enclosed_volume(mesh), 0.0);
  const std::vector<ObjectLight> light{sun(mesh)};
  const ObjectResult coarse = solve_object(mesh, ObjectMedium(wax), light, 0.1);
  const ObjectResult fine = solve_object(mesh, ObjectMedium(wax), light, 0.01);
  EXPECT_TRUE(coarse.converged);
  EXPECT_THAT(coarse.warnings, testing::Not(testing::Contains(testing::HasSubstr("slits"))));
  EXPECT_LE(relative_difference(mesh, coarse.exitance, fine.exitance), coarse.error_estimate[0]);
}

TEST(EmbeddedModel, LightThatMeetsAVoidsWallAgainIsTheGeometricSeries) {
  // All that leaves the wall of a spherical void meets it again, evenly; nothing does on a convex
  // body.
  Eigen::Affine3d smaller(Eigen::Scaling(0.5));
  const TriangleMesh ball = icosphere(5.0, 3, {0.0, 0.0, 0.0});
  const TriangleMesh shell = joined(ball, transformed(ball, smaller), true);
  const std::size_t half = ball.triangles.size();
  ObjectLight light;
  light.diffuse.assign(2 * half, 0.0);
  std::fill(light.diffuse.begin() + static_cast<std::ptrdiff_t>(half), light.diffuse.end(), 1.0);
  const Surface surface = surface_of(shell);
  const auto rays = make_caster(shell);
  const ObjectMedium medium(wax);
  const std::vector<ObjectLight> lights{light};
  const ObjectProblem problem{shell, surface, *rays, medium, eta, lights};
  Progress progress;
  ObjectOptions options;
  const ObjectResult lost = EmbeddedModel().solve(problem, options, progress);
  const auto inward = [&](const ObjectResult& result) {
    double power = 0.0;
    for (std::size_t t = half; t < 2 * half; ++t) power += surface.area[t] * result.exitance[t];
    return power;
  };
  constexpr double facets = 0.01;
  EXPECT_NEAR(lost.balance[0].reentering / inward(lost), 1.0, facets);

  options.follow_reentry = true;
  const ObjectResult followed = EmbeddedModel().solve(problem, options, progress);
  EXPECT_TRUE(followed.converged);
  const ObjectBalance& b = followed.balance[0];
  EXPECT_NEAR((b.exiting + b.absorbed + b.unscattered) / b.entering, 1.0, 1e-6);
  // Each round sends M = back · E off the wall and reflects (1 − T) E, all of which is the next E;
  // the first E is that of the light, whose own reflection is not followed.
  const double T = diffuse_transmittance(boundary_constants(eta));
  double area = 0.0;
  for (std::size_t t = half; t < 2 * half; ++t) area += surface.area[t];
  const double back = inward(lost) / area;
  const double expected = inward(lost) * T / (T - back);
  EXPECT_NEAR(inward(followed) / expected, 1.0, 0.03);

  const ObjectResult convex = solve_object(ball, medium, {sky(ball)});
  EXPECT_LE(convex.balance[0].reentering, 1e-3 * convex.balance[0].exiting);
}

TEST(EmbeddedModel, RefusesInOneSentence) {
  const TriangleMesh mesh = box({5.0, 5.0, 5.0}, 2);
  const std::vector<ObjectLight> lights{sky(mesh)};
  const auto refusal = [&](const TriangleMesh& asked, const std::vector<ObjectLight>& lit,
                           std::optional<std::uint64_t> most = std::nullopt) {
    const Surface surface = surface_of(asked);
    const auto rays = make_caster(mesh);
    const ObjectMedium medium(wax);
    Progress progress;
    ObjectOptions options;
    options.max_elements = most;
    try {
      EmbeddedModel().solve({asked, surface, *rays, medium, eta, lit}, options, progress);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing refused");
  };
  EXPECT_THAT(refusal(mesh, lights, 10), testing::HasSubstr("10 are allowed; raise max_elements"));
  TriangleMesh broken = mesh;
  broken.vertices[3].y() = std::nan("");
  EXPECT_THAT(refusal(broken, lights), testing::HasSubstr("vertex 3 of the mesh is not finite"));
  EXPECT_THAT(refusal({}, lights), testing::HasSubstr("no triangles"));
  ObjectLight short_light;
  short_light.diffuse = {1.0};
  EXPECT_THAT(refusal(mesh, {short_light}), testing::HasSubstr("light 0 has 1 irradiances"));
  ObjectLight from_inside;
  from_inside.beams.push_back({0, surface_of(mesh).position[0], surface_of(mesh).normal[0], 1.0});
  EXPECT_THAT(refusal(mesh, {from_inside}), testing::HasSubstr("from inside the object"));
}

/// What is reported first.
class FirstDetail : public Progress {
 public:
  void update(const std::string&, double, const std::string& said) override {
    if (detail.empty()) detail = said;
  }
  std::string detail;
};

TEST(EmbeddedModel, StopsAtTheMostCubesAllowedAndReportsIt) {
  const TriangleMesh mesh = icosphere(5.0, 3, {0.0, 0.0, 0.0});
  const Surface surface = surface_of(mesh);
  const auto rays = make_caster(mesh);
  const ObjectMedium medium(wax);
  const std::vector<ObjectLight> lights{sky(mesh)};
  FirstDetail progress;
  ObjectOptions options;
  options.tolerance = 1e-6;
  options.max_elements = 20'000;
  const ObjectResult result =
      EmbeddedModel().solve({mesh, surface, *rays, medium, eta, lights}, options, progress);
  EXPECT_THAT(progress.detail, testing::MatchesRegex("at most 20000 cubes, [0-9.]+ GB"))
      << "stated before the work";
  EXPECT_FALSE(result.converged);
  EXPECT_LE(result.elements, 20'000U);
  EXPECT_GT(result.error_estimate[0], 1e-6);
  EXPECT_THAT(result.message, testing::HasSubstr("the most allowed"));
}

}  // namespace
}  // namespace kappamu::forward::embedded
