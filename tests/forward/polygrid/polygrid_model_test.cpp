// Answers on polygrids, split until they are within the tolerance: against closed forms and against
// `embedded`, which shares no discretisation with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../embedded/exact_sphere.h"
#include "core/error.h"
#include "core/mesh/shapes.h"
#include "core/mesh/surface_norm.h"
#include "forward/embedded/embedded_model.h"
#include "forward/light_entry.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/live_polygrid.h"
#include "forward/polygrid/polygrid_solve.h"
#include "forward/polygrid/split_polygrid.h"
#include "tests/cases/made_polygrid.h"
#include "tests/forward/lit_object.h"

namespace kappamu::forward::polygrid {
namespace {

using Eigen::Vector3d;

constexpr double radius = 5.0;

/// Voxels of 1.25 mm drawn within a factor of three either way.
ObjectMedium random_medium() {
  const GridShape shape{8, 8, 8, 1.25};
  auto volume = std::make_shared<Medium>(Medium{Volume<double>(shape), Volume<double>(shape)});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> factor(-std::log(3.0), std::log(3.0));
  for (std::size_t k = 0; k < shape.cells(); ++k) {
    volume->kappa[k] = 0.2 * std::exp(factor(random));
    volume->mu[k] = 0.02 * std::exp(factor(random));
  }
  Eigen::Affine3d volume_from_object = Eigen::Affine3d::Identity();
  volume_from_object.translation().setConstant(radius);
  return ObjectMedium(volume, volume_from_object, Wrap::clamp);
}

struct Ball : LitObject {
  explicit Ball(const ObjectMedium& filling) : LitObject(sphere_mesh(radius, 40), filling) {
    lights = {parallel_beams(surface, Vector3d(1, -2, -2) / 3.0), {}};
    for (const Vector3d& normal : surface.normal) lights[1].diffuse.push_back(1.0 + normal[0]);
  }
};

void expect_as_embedded(const Ball& ball, double tolerance) {
  const ObjectProblem problem = ball.problem();
  ObjectOptions options;
  options.tolerance = tolerance;
  Progress silent;
  const ObjectResult ours =
      solve_on_polygrid(ball_polygrid(8, radius), {&problem, 1}, options, silent).front();
  options.tolerance = 0.5 * tolerance;
  const ObjectResult theirs = EmbeddedModel().solve(problem, options, silent);
  EXPECT_TRUE(ours.converged) << ours.message;
  const std::size_t samples = ball.surface.size();
  for (std::size_t l = 0; l < ball.lights.size(); ++l) {
    const std::span a = std::span(ours.exitance).subspan(l * samples, samples);
    const std::span b = std::span(theirs.exitance).subspan(l * samples, samples);
    EXPECT_LE(surface_difference(ball.surface, a, b) / surface_norm(ball.surface, b),
              ours.error_estimate[l] + theirs.error_estimate[l])
        << "light " << l << ": " << ours.error_estimate[l] << ", " << theirs.error_estimate[l];
    const ObjectBalance& balance = ours.balance[l];
    EXPECT_NEAR(balance.exiting + balance.absorbed + balance.unscattered, balance.entering,
                1e-4 * balance.entering);
  }
}

TEST(PolygridModel, AnswersAsEmbeddedOnOneMaterial) {
  expect_as_embedded(Ball(ObjectMedium({0.2, 0.02})), 0.02);
}

TEST(PolygridModel, AnswersAsEmbeddedOnAVolume) {
  expect_as_embedded(Ball(random_medium()), 0.06);
}

TEST(PolygridModel, ChannelsTogetherAreChannelsAlone) {
  const Ball red(ObjectMedium({0.3, 0.01})), blue(ObjectMedium({0.1, 0.1}));
  const std::vector<ObjectProblem> problems{red.problem(), blue.problem()};
  ObjectOptions options;
  options.tolerance = 0.2;
  Progress silent;
  const auto together = solve_on_polygrid(ball_polygrid(6, radius), problems, options, silent);
  for (std::size_t c = 0; c < 2; ++c) {
    const auto alone =
        solve_on_polygrid(ball_polygrid(6, radius), {&problems[c], 1}, options, silent).front();
    constexpr double linear = 1e-3;  // both within the solver's tolerance of the same answer
    for (std::size_t i = 0; i < alone.exitance.size(); ++i) {
      EXPECT_NEAR(together[c].exitance[i], alone.exitance[i], linear);
    }
  }
}

TEST(PolygridModel, SaysWhereItStopped) {
  const Ball ball(ObjectMedium({0.2, 0.02}));
  const ObjectProblem problem = ball.problem();
  ObjectOptions options;
  options.tolerance = 1e-5;
  options.max_elements = 4000;
  Progress silent;
  const ObjectResult result =
      solve_on_polygrid(ball_polygrid(6, radius), {&problem, 1}, options, silent).front();
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.elements, 1728U);
  EXPECT_THAT(result.message, testing::HasSubstr("stopped at 1728 cells"));
  EXPECT_THAT(result.message, testing::HasSubstr("4000 cells allowed; raise max_elements"));
  options.max_elements = 1000;
  EXPECT_THROW(solve_on_polygrid(ball_polygrid(6, radius), {&problem, 1}, options, silent),
               InputError);
}

TEST(PolygridModel, CellsNeededAreThoseOfALaw) {
  // Errors c·N^(-p/3) at several orders: the number follows from two of them.
  for (const double order : {0.7, 1.0, 1.6}) {
    const auto error = [&](double cells) { return 5.0 * std::pow(cells, -order / 3.0); };
    const double found = polygrid_order(2e4, error(2e4), 7e4, error(7e4));
    EXPECT_NEAR(found, order, 1e-9);
    EXPECT_NEAR(error(polygrid_cells_needed(7e4, error(7e4), 0.01, found)), 0.01, 1e-9);
  }
  EXPECT_GT(polygrid_order(2e4, 0.1, 4e4, 0.2),
            0.0);  // an error that grew asks for a finite number
}

TEST(PolygridModel, MakesTheNextPolygridAsFineAsTheToleranceNeeds) {
  const Ball ball(ObjectMedium({0.2, 0.02}));
  const ObjectProblem problem = ball.problem();
  ObjectOptions options;
  Progress silent;
  const auto solved = [&](const PolygridMaker& maker) {
    return solve_on_polygrid(ball_polygrid(4, radius), {&problem, 1}, options, silent, maker)
        .front();
  };
  options.tolerance = 0.9;  // what the first says
  const double first = solved({}).error_estimate[0];
  options.tolerance = 0.55 * first;
  std::vector<int> asked;
  const ObjectResult result = solved([&](int cells) {
    asked.push_back(cells);
    return ball_polygrid(static_cast<int>(std::lround(std::cbrt(cells))), radius);
  });
  EXPECT_TRUE(result.converged) << result.message;
  ASSERT_FALSE(asked.empty());
  EXPECT_LT(asked.front(), 8 * 64);  // fewer than a split would give
}

TEST(PolygridModel, StopsBeforeCellsThatTheBoundForbids) {
  // A maker whose polygrids do not improve: the bound is not spent on them.
  const Ball ball(ObjectMedium({0.2, 0.02}));
  const ObjectProblem problem = ball.problem();
  ObjectOptions options;
  options.tolerance = 1e-4;
  options.max_elements = 200'000;
  Progress silent;
  const ObjectResult result =
      solve_on_polygrid(ball_polygrid(4, radius), {&problem, 1}, options, silent, [](int) {
        return ball_polygrid(5, radius);
      }).front();
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.elements, 1000U);
  EXPECT_THAT(result.message, testing::ContainsRegex("needs about [0-9]+ cells \\([0-9.]+ GB\\)"));
}

TEST(PolygridSplit, IsTheBoxOfHalvedCells) {
  const Vector3d size(3, 2, 1);
  const Polygrid coarse = box_polygrid({3, 2, 2}, size);
  const Polygrid fine = split(coarse, surface_of_grid(coarse));
  const Polygrid expected = box_polygrid({6, 4, 4}, size);
  ASSERT_EQ(fine.cell, expected.cell);
  EXPECT_EQ(fine.cell_corners, expected.cell_corners);
  EXPECT_EQ(fine.link, expected.link);
  for (std::size_t i = 0; i < fine.corner.size(); ++i) {
    EXPECT_LE((fine.corner[i] - expected.corner[i]).norm(), 1e-12);
  }
}

TEST(PolygridSplit, BringsNewCornersToTheSurface) {
  const Polygrid coarse = ball_polygrid(6, radius);
  const TriangleMesh sphere = sphere_mesh(radius, 60);
  const Polygrid fine = split(coarse, sphere);
  const auto volume = [](const Polygrid& grid) { return enclosed_volume(surface_of_grid(grid)); };
  const double exact = enclosed_volume(sphere);
  // By half the edge a quarter of what is missing.
  EXPECT_NEAR((exact - volume(fine)) / (exact - volume(coarse)), 0.25, 0.06);
}

/// Beyond 200,000 cells the first grid is one with an eighth of them, split.
TEST(LivePolygrid, BeginsWithManyCellsWhereTheyAreAskedFor) {
  constexpr int asked = 240'000;
  const Ball ball(random_medium());
  MediaOfChannels media;
  media.fill(std::make_shared<const ObjectMedium>(ball.medium));
  const LiveBody body{ball.mesh, ball.surface, *ball.rays, media, ball.eta};
  const ObjectOptions options;
  Progress silent;
  LivePolygrid live(body, asked, options, silent);
  EXPECT_EQ(live.levels(), 1);  // the next would have more than 1.5 million
  LightOfChannels light;
  light.fill(ball.lights[1]);
  const LiveModel::Answer answer = live.solve(light, 0, silent);
  EXPECT_TRUE(answer.converged);
  EXPECT_NEAR(static_cast<double>(answer.elements), asked, 0.15 * asked);
  const ObjectProblem problem = ball.problem();
  ObjectOptions fine;
  fine.tolerance = 0.03;
  const ObjectResult theirs = EmbeddedModel().solve(problem, fine, silent);
  const std::span<const double> b = std::span(theirs.exitance).last(ball.surface.size());
  EXPECT_LE(surface_difference(ball.surface, answer.exitance[0], b) / surface_norm(ball.surface, b),
            LivePolygrid::accuracy.linear_tolerance + theirs.error_estimate[1]);
}

}  // namespace
}  // namespace kappamu::forward::polygrid
