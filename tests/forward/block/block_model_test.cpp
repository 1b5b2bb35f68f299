// Model `grid` of objects: power is balanced, diffuse light in equilibrium stays, the answer is
// `embedded`'s within the errors that both state, and what is no block is refused.
#include "forward/block/block_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "core/mesh/surface_norm.h"
#include "forward/block/block_diffusion.h"
#include "forward/embedded/embedded_model.h"
#include "tests/forward/lit_object.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

using Eigen::Vector3d;

constexpr double eta = 1.3;
const Vector3d edges(6.0, 4.0, 3.0);

/// 12 × 8 × 6 voxels of 0.5 mm, coefficients drawn within a factor of three either way.
std::shared_ptr<const Medium> random_volume(unsigned seed) {
  const GridShape shape{12, 8, 6, 0.5};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> factor(-std::log(3.0), std::log(3.0));
  auto medium = std::make_shared<Medium>(Medium{Volume<double>(shape), Volume<double>(shape)});
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    medium->kappa[i] = 0.2 * std::exp(factor(random));
    medium->mu[i] = 0.02 * std::exp(factor(random));
  }
  return medium;
}

struct Block : LitObject {
  explicit Block(const ObjectMedium& filling, int tessellation = 24)
      : LitObject(box_mesh(edges, tessellation), filling) {}
};

ObjectMedium random_medium(unsigned seed) {
  Eigen::Affine3d volume_from_object = Eigen::Affine3d::Identity();
  volume_from_object.translate(0.5 * edges);
  return {random_volume(seed), volume_from_object, Wrap::clamp};
}

TEST(BlockModel, BalancesPowerOfObliqueBeamsAndOfDiffuseLight) {
  Block block(random_medium(1));
  block.lights = {parallel_beams(block.surface, Vector3d(0.3, -0.5, -1.0).normalized()), {}};
  block.lights[1].diffuse.assign(block.surface.size(), 0.7);
  Progress progress;
  const ObjectResult result = BlockModel().solve(block.problem(), {}, progress);
  for (const ObjectBalance& balance : result.balance) {
    EXPECT_GT(balance.entering, 1.0);
    EXPECT_NEAR(balance.unscattered + balance.exiting + balance.absorbed, balance.entering,
                1e-4 * balance.entering);
  }
}

/// Where nothing is absorbed, even light from everywhere sees η² times itself inside: what enters
/// leaves.
TEST(BlockModel, EvenLightFromEverywhereLeavesAsItEnters) {
  Block block(ObjectMedium(Coefficients{0.3, 0.0}));
  block.lights.resize(1);
  block.lights[0].diffuse.assign(block.surface.size(), 1.0);
  Progress progress;
  const ObjectResult result = BlockModel().solve(block.problem(), {}, progress);
  const BoundaryConstants constants = boundary_constants(eta);
  const double entering = eta * eta * (1.0 - constants.r_phi);
  for (const double exitance : result.exitance) EXPECT_NEAR(exitance, entering, 1e-4 * entering);
}

TEST(BlockModel, AgreesWithEmbeddedWithinStatedErrors) {
  for (const unsigned seed : {2U, 3U, 4U}) {
    Block block(random_medium(seed));
    block.lights = {parallel_beams(block.surface, Vector3d(0.4, 0.3, -1.0).normalized()), {}};
    block.lights[1].diffuse.assign(block.surface.size(), 0.7);
    Progress progress;
    ObjectOptions options;
    options.tolerance = 0.02;
    const ObjectResult grid = BlockModel().solve(block.problem(), options, progress);
    const ObjectResult cut = EmbeddedModel().solve(block.problem(), options, progress);
    EXPECT_TRUE(grid.converged) << grid.message;
    const std::size_t samples = block.surface.size();
    for (std::size_t l = 0; l < 2; ++l) {
      const auto mine = std::span(grid.exitance).subspan(l * samples, samples);
      const auto other = std::span(cut.exitance).subspan(l * samples, samples);
      const double apart =
          surface_difference(block.surface, mine, other) / surface_norm(block.surface, other);
      EXPECT_LT(apart, grid.error_estimate[l] + cut.error_estimate[l])
          << "seed " << seed << ", light " << l;
    }
  }
}

TEST(BlockModel, AnswersDoNotDependOnTheTessellation) {
  std::vector<double> exiting;
  for (const int tessellation : {6, 12, 48}) {
    Block block(random_medium(5), tessellation);
    block.lights.resize(1);
    block.lights[0].diffuse.assign(block.surface.size(), 1.0);
    Progress progress;
    exiting.push_back(BlockModel().solve(block.problem(), {}, progress).balance[0].exiting);
  }
  EXPECT_NEAR(exiting[0], exiting[2], 1e-4 * exiting[2]);
  EXPECT_NEAR(exiting[1], exiting[2], 1e-4 * exiting[2]);
}

TEST(BlockDiffusion, FollowsAChangedMediumFromItsLastAnswer) {
  Block block(random_medium(6));
  block.lights = {parallel_beams(block.surface, -Vector3d::UnitZ())};
  const ObjectMedium other = random_medium(7);
  const block::BlockGrid grid = block::require_block_grid(block.mesh, block.medium);
  const block::FaceMap map(grid, block.mesh, block.surface);
  block::BlockDiffusion kept(grid, map, eta, "auto"), fresh(grid, map, eta, "auto");
  kept.set_medium(block.medium);
  kept.solve(block.problem(), {});
  kept.set_medium(other);
  fresh.set_medium(other);
  const block::BlockAnswer one = kept.solve(block.problem(), {}),
                           two = fresh.solve(block.problem(), {});
  const double apart = surface_difference(block.surface, one.exitance, two.exitance);
  EXPECT_LT(apart, 1e-4 * surface_norm(block.surface, two.exitance));
  EXPECT_LT(kept.solve(block.problem(), {}).report.iterations, 2) << "from its own answer";
}

TEST(BlockModel, RefusesWhatIsNoBlock) {
  const ObjectMedium even(Coefficients{0.3, 0.01});
  EXPECT_FALSE(block::block_grid(sphere_mesh(3.0, 8), even));
  EXPECT_FALSE(block::block_grid(make_shape("box-with-void", 6.0, 8), even));
  EXPECT_TRUE(block::block_grid(box_mesh(edges, 8), even));
  Eigen::Affine3d stretched = Eigen::Affine3d::Identity();
  stretched.scale(Vector3d(1.0, 1.0, 1.3)).translate(0.5 * edges);
  EXPECT_FALSE(block::block_grid(box_mesh(edges, 8),
                                 ObjectMedium(random_volume(1), stretched, Wrap::clamp)));
  Block block(ObjectMedium(random_volume(1), stretched, Wrap::clamp));
  block.lights.resize(1);
  Progress progress;
  EXPECT_THAT(sentence_of([&] { BlockModel().solve(block.problem(), {}, progress); }),
              testing::HasSubstr("take 'embedded'"));
}

}  // namespace
}  // namespace kappamu::forward
