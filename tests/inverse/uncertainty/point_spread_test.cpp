// The width of what a fit finds of a point, where it is known in closed form.
#include "inverse/uncertainty/point_spread.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {
namespace {

constexpr GridShape shape{64, 64, 1, 0.5};  // a layer: nothing couples depths
const MediumSpace space{shape, 2, 4.0};
const Prior prior{300.0, 40.0};

/// Of data that determine each wave of either coefficient with the same weight.
PointSpread spread_at(double weight) {
  const LateralModes modes(space);
  const Eigen::MatrixXd block = weight * Eigen::MatrixXd::Identity(modes.rows(), modes.rows());
  const LateralBlocks blocks(static_cast<std::size_t>(modes.bins()), block);
  return point_spread(prior_metric(prior, space), posterior_metric(prior, space, blocks), space);
}

/// Of a coefficient that is charged `charge` times: d = α h/ℓ (λ + (h/L)²) there.
double expected_mm(double weight, double charge) {
  const double smooth = charge * prior.weight * shape.voxel_mm / space.thickness_mm;
  const double eigenvalue = weight / smooth - std::pow(shape.voxel_mm / prior.anchor_length_mm, 2);
  return 4.0 * std::numbers::ln2 * shape.voxel_mm / std::sqrt(eigenvalue);
}

TEST(PointSpread, IsThatOfTheWaveWhichTheFitFindsHalfOf) {
  constexpr double between_bins = 0.1;
  const double charge = std::pow(absorbers_vary, -2);
  for (const double weight : {0.3, 1.0, 3.0}) {
    const PointSpread found = spread_at(weight);
    ASSERT_EQ(found.kappa_mm.size(), 1U);
    EXPECT_NEAR(found.kappa_mm[0] / expected_mm(weight, 1.0), 1.0, between_bins) << weight;
    EXPECT_NEAR(found.mu_mm[0] / expected_mm(weight, charge), 1.0, between_bins) << weight;
  }
}

TEST(PointSpread, IsTheBlockWhereDataSayNothingAndAVoxelWhereTheySayAll) {
  EXPECT_EQ(spread_at(0.0).kappa_mm[0], 32.0);
  EXPECT_EQ(spread_at(0.0).mu_mm[0], 32.0);
  EXPECT_EQ(spread_at(1e6).kappa_mm[0], 0.0);
  EXPECT_EQ(spread_at(1e6).mu_mm[0], 0.0);
}

}  // namespace
}  // namespace kappamu::inverse
