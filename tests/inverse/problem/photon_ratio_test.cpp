// Transport over diffusion by photons: right on average, as noisy as it says, the same for the same
// seed, and as many photons as the data deserve. Whether transport itself is right is
// tests/forward/montecarlo's to say.
#include "inverse/problem/photon_ratio.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "core/progress.h"
#include "device/device_info.h"
#include "forward/montecarlo/monte_carlo_model.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

class PhotonRatioTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }
};

/// One lit corner of a block of `shape`; data of deviation `noise` times their value.
PhotonProblem corner_lit(const GridShape& shape, double kappa, double mu, double noise) {
  PhotonProblem p;
  p.setup.shape = shape;
  p.kappa.assign(shape.cells(), kappa);
  p.mu.assign(shape.cells(), mu);
  p.seen_shape = face_shape(shape, p.seen_face);
  p.patterns = 1;
  p.irradiance.assign(p.seen_shape.cells(), 0.0);
  for (int v = 0; v < shape.ny / 2; ++v) {
    for (int u = 0; u < shape.nx / 2; ++u) {
      p.irradiance[static_cast<std::size_t>(v * shape.nx + u)] = 1.0;
    }
  }
  const CoefficientPair even{std::vector<double>(shape.cells(), std::log(kappa)),
                             std::vector<double>(shape.cells(), std::log(mu))};
  p.diffusion = cases::simulate(p.setup, even, p.seen_face, p.irradiance, 1, "auto");
  for (const double m : p.diffusion) p.variance.push_back(std::pow(noise * m, 2));
  return p;
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double corrected_sum(const PhotonProblem& p, const PhotonRatio& found) {
  double total = 0.0;
  for (std::size_t i = 0; i < p.diffusion.size(); ++i) total += found.ratio[i] * p.diffusion[i];
  return total;
}

// docs/validity.md: at albedo 0.999 and 8 mean free paths diffusion transmits 1 % too little.
TEST_F(PhotonRatioTest, IsNearOneWhereDiffusionHolds) {
  constexpr GridShape shape{8, 8, 16, 0.25};
  constexpr double kappa = 1.0 / 6.0, mu = 0.002;
  PhotonProblem p = corner_lit(shape, kappa, mu, 0.05);
  p.setup.sides = Sides::mirror;
  std::fill(p.irradiance.begin(), p.irradiance.end(), 1.0);
  const CoefficientPair even{std::vector<double>(shape.cells(), std::log(kappa)),
                             std::vector<double>(shape.cells(), std::log(mu))};
  p.diffusion = cases::simulate(p.setup, even, p.seen_face, p.irradiance, 1, "auto");
  const PhotonRatio found = photon_ratio(p, {});
  constexpr double three_percent = 0.03;
  EXPECT_NEAR(corrected_sum(p, found) / sum(p.diffusion), 1.0, three_percent);
}

TEST_F(PhotonRatioTest, IsThatOfTransportBeyond) {
  // Albedo 0.7, a table of docs/validity.md: 30 % less is transmitted by diffusion at 8 mean free
  // paths; mirrors make the corner's block a slab's neighbour, and totals near enough a slab's.
  PhotonProblem p = corner_lit({8, 8, 16, 0.5}, 1.0 / 3.0, 0.3, 0.05);
  std::fill(p.irradiance.begin(), p.irradiance.end(), 1.0);
  p.setup.sides = Sides::mirror;
  const CoefficientPair even{std::vector<double>(p.kappa.size(), std::log(p.kappa[0])),
                             std::vector<double>(p.mu.size(), std::log(p.mu[0]))};
  forward::GridSetup fine = p.setup;
  fine.shape = p.setup.shape.refined(2);
  const auto split = [&](const std::vector<double>& v) {
    return split_voxels(v, p.setup.shape, fine.shape, 2);
  };
  p.diffusion =
      restrict_face(cases::simulate(fine, {split(even.log_kappa), split(even.log_mu)}, p.seen_face,
                                    std::vector<double>(4 * p.irradiance.size(), 1.0), 1, "auto"),
                    face_shape(fine.shape, p.seen_face), p.seen_shape, 2, 1);
  const PhotonRatio found = photon_ratio(p, {});
  const double table = 1.0 / (1.0 - 0.296);
  constexpr double noise_and_grid = 0.06;
  EXPECT_NEAR(corrected_sum(p, found) / sum(p.diffusion) / table, 1.0, noise_and_grid);
}

TEST_F(PhotonRatioTest, SpreadsFromSeedToSeedAsItSays) {
  const PhotonProblem p = corner_lit({10, 10, 4, 0.3}, 0.2, 0.01, 0.03);
  constexpr int seeds = 60;
  const std::size_t cells = p.diffusion.size();
  std::vector<double> mean(cells, 0.0), square(cells, 0.0);
  std::vector<double> totals;
  double stated = 0.0, stated_total = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const PhotonRatio found = photon_ratio(p, {"auto", static_cast<std::uint64_t>(seed)});
    for (std::size_t i = 0; i < cells; ++i) {
      const double m = found.ratio[i] * p.diffusion[i];
      mean[i] += m / seeds;
      square[i] += m * m / seeds;
    }
    totals.push_back(corrected_sum(p, found));
    stated += sum(found.variance) / seeds;
    stated_total += sum(found.pixel_variance) / seeds;
  }
  double spread = 0.0;
  for (std::size_t i = 0; i < cells; ++i) spread += square[i] - mean[i] * mean[i];
  spread *= seeds / (seeds - 1.0);
  // Some hundred independent pixels, 60 times: 2 %; how near the weights are to alike: 10 %.
  constexpr double of_pixels = 0.15;
  EXPECT_NEAR(spread / stated, 1.0, of_pixels);
  // Of one number 60 times the variance is known to 18 %, three of which are allowed. A total
  // hardly changes by smoothing, which the single pixels' variances say and the smoothed ones do
  // not.
  const double middle = sum(totals) / seeds;
  double total_spread = 0.0;
  for (const double t : totals) total_spread += (t - middle) * (t - middle) / (seeds - 1.0);
  constexpr double of_total = 0.55;
  EXPECT_NEAR(total_spread / stated_total, 1.0, of_total);
}

TEST_F(PhotonRatioTest, IsQuieterThanItsDataByPhotonsAndBySmoothing) {
  std::uint64_t before = 0;
  for (const double noise : {0.08, 0.04, 0.02}) {
    const PhotonProblem p = corner_lit({10, 10, 4, 0.3}, 0.2, 0.01, noise);
    const PhotonRatio found = photon_ratio(p, {});
    std::size_t single = 0;
    for (std::size_t i = 0; i < p.diffusion.size(); ++i) {
      EXPECT_LE(found.variance[i], 0.25 * p.variance[i] * (1.0 + 1e-9)) << i;
      EXPECT_GE(found.pixel_variance[i], found.variance[i]) << i;
      single += found.pixel_variance[i] <= p.variance[i] ? 1 : 0;
    }
    // Chosen for the median, with every photon's weight taken as 1.
    EXPECT_GT(single, p.diffusion.size() / 2);
    if (before > 0) {
      EXPECT_NEAR(static_cast<double>(found.photons) / static_cast<double>(before), 4.0, 0.1);
    }
    before = found.photons;
  }
}

/// `p` with log κ and log μ of all voxels higher by so much.
PhotonProblem moved(PhotonProblem p, double log_kappa, double log_mu) {
  const std::size_t cells = p.kappa.size();
  for (double& kappa : p.kappa) kappa *= std::exp(log_kappa);
  for (double& mu : p.mu) mu *= std::exp(log_mu);
  const CoefficientPair even{std::vector<double>(cells, std::log(p.kappa[0])),
                             std::vector<double>(cells, std::log(p.mu[0]))};
  p.diffusion = cases::simulate(p.setup, even, p.seen_face, p.irradiance, 1, "auto");
  return p;
}

// At 3κμ = 0.3, where the ratio changes with κ as much as diffusion does, and with another sign
// under the light than beside it.
TEST_F(PhotonRatioTest, ItsSlopeForetellsItElsewhere) {
  PhotonProblem p = corner_lit({10, 10, 8, 0.4}, 0.3, 0.33, 0.02);
  const std::size_t cells = p.diffusion.size();
  EXPECT_TRUE(photon_ratio(p, {}).slope[0].empty());
  p.diffusion_below = {moved(p, -slope_step, 0.0).diffusion, moved(p, 0.0, -slope_step).diffusion};
  const PhotonRatio here = photon_ratio(p, {});
  constexpr double step = 0.2;
  for (std::size_t unknown = 0; unknown < 2; ++unknown) {
    ASSERT_EQ(here.slope[unknown].size(), cells);
    const PhotonRatio there =
        photon_ratio(moved(p, unknown == 0 ? step : 0.0, unknown == 1 ? step : 0.0), {});
    double missed = 0.0, change = 0.0;
    for (std::size_t i = 0; i < cells; ++i) {
      const double found = std::log(there.ratio[i] / here.ratio[i]) / step;
      missed += p.diffusion[i] * std::pow(here.slope[unknown][i] - found, 2);
      change += p.diffusion[i] * found * found;
    }
    EXPECT_LT(missed, 0.5 * change) << unknown;
  }
}

TEST_F(PhotonRatioTest, EqualSeedsGiveEqualBitsAndOthersOthers) {
  const PhotonProblem p = corner_lit({7, 5, 4, 0.3}, 0.2, 0.01, 0.05);
  const PhotonRatio first = photon_ratio(p, {"auto", 1});
  EXPECT_EQ(first.ratio, photon_ratio(p, {"auto", 1}).ratio);
  EXPECT_NE(first.ratio, photon_ratio(p, {"auto", 2}).ratio);
}

TEST_F(PhotonRatioTest, ReadsAnyCoefficientsThatAFitPasses) {
  PhotonProblem p = corner_lit({7, 5, 4, 0.3}, 0.2, 0.01, 0.3);
  p.mu[3] = 40.0;     // no scattering left
  p.kappa[8] = 1e-9;  // by itself a majorant 2e8 times the others' extinction
  p.variance[2] = std::numeric_limits<double>::infinity();
  const auto is_possible = [&] {
    for (const double r : photon_ratio(p, {}).ratio) {
      if (!std::isfinite(r) || r < 0.0) return false;
    }
    return true;
  };
  EXPECT_TRUE(is_possible());
  std::fill(p.kappa.begin(), p.kappa.end(), 1e-9);
  EXPECT_TRUE(is_possible());
}

// What justifies the bound on κ: beyond it less diffusion is no longer seen.
TEST_F(PhotonRatioTest, AVoxelBelowTheLeastKappaIsAMirror) {
  const PhotonProblem p = corner_lit({5, 5, 4, 0.3}, 0.2, 0.01, 0.05);
  const auto transmitted = [&](double middle) {
    forward::ForwardProblem walk{
        p.setup,
        {Volume<double>(p.setup.shape, p.kappa), Volume<double>(p.setup.shape, p.mu)},
        1,
        std::vector<double>(p.irradiance.size(), 1.0)};
    walk.medium.kappa[p.setup.shape.index(2, 2, 2)] = middle;
    forward::ForwardOptions how;
    how.photons = 1 << 17;
    Progress silent;
    return sum(forward::make_monte_carlo_model()->solve(walk, how, silent).exitance[5]);
  };
  const double least = transmitted(0.2 / 50.0);
  EXPECT_GT(std::abs(transmitted(0.2) / least - 1.0), 0.02);
  constexpr double noise_and_limit = 0.01;  // three standard errors of the difference: 0.8 %
  EXPECT_NEAR(transmitted(0.2 / 200.0) / least, 1.0, noise_and_limit);
}

TEST_F(PhotonRatioTest, IsOneUnderAPatternWithoutLight) {
  PhotonProblem p = corner_lit({7, 5, 4, 0.3}, 0.2, 0.01, 0.05);
  std::fill(p.irradiance.begin(), p.irradiance.end(), 0.0);
  std::fill(p.diffusion.begin(), p.diffusion.end(), 0.0);
  for (const double r : photon_ratio(p, {}).ratio) EXPECT_EQ(r, 1.0);
}

}  // namespace
}  // namespace kappamu::inverse
