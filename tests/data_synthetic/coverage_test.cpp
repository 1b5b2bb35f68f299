// Whether the truth lies within what a fit states: small structured blocks whose light is
// diffusion's on a finer grid, so that nothing but noise, smoothing and the grid stands between fit
// and truth.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "bench/cases/inverse_case.h"
#include "core/progress.h"
#include "data_synthetic/scene/materials.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_uncertainty.h"

namespace kappamu::synthetic {
namespace {

struct Found {
  double kappa_within = 0.0;  ///< share of voxels within two standard deviations
  double mu_within = 0.0;
  double kappa_within_at_seen_face = 0.0;
};

struct Setup {
  const char* sample;
  int patches;  ///< along either axis of the lit face
  const char* device;
};

/// The red coefficients at 1 % noise.
Found coverage_of(const Setup& setup, std::uint64_t seed) {
  const SampleModel sample = make_sample(setup.sample, seed);
  bench::Block block;
  block.grid = sample.grid;
  const GridShape finer = sample.grid.refined(2);
  const Medium truth = sample_medium(sample, finer)[0];
  const inverse::CoefficientPair logs = inverse::to_fields(truth);
  inverse::FitOptions options;
  options.path.model = inverse::Model::volume;
  options.uncertainty.probes = inverse::usual_probes;
  options.solver.backend.device = setup.device;
  Progress silent;
  const SurfaceMeasurements measured = bench::measure(block, logs, setup.patches, seed);
  const inverse::ChannelFit fit =
      inverse::fit_channel(measured, 0, options, inverse::Checkpoint{}, silent);
  const double valley = inverse::shared_valley({&fit, 1}, measured.lit_face);
  const inverse::Uncertainty stated = inverse::estimate_volume_uncertainty(fit, valley, measured);
  Found found;
  const auto share = 1.0 / static_cast<double>(sample.grid.cells());
  for (int z = 0; z < sample.grid.nz; ++z) {
    for (int y = 0; y < sample.grid.ny; ++y) {
      for (int x = 0; x < sample.grid.nx; ++x) {
        double kappa = 0.0;
        double mu = 0.0;
        for (int corner = 0; corner < 8; ++corner) {
          const std::size_t at =
              finer.index(2 * x + (corner & 1), 2 * y + (corner >> 1 & 1), 2 * z + (corner >> 2));
          kappa += truth.kappa[at] / 8.0;
          mu += truth.mu[at] / 8.0;
        }
        const std::size_t i = sample.grid.index(x, y, z);
        const double of_kappa = std::abs(std::log(fit.medium.kappa[i] / kappa));
        const double of_mu = std::abs(std::log(fit.medium.mu[i] / mu));
        if (of_mu <= 2.0 * stated.log_mu_std[i]) found.mu_within += share;
        if (of_kappa > 2.0 * stated.log_kappa_std[i]) continue;
        found.kappa_within += share;
        if (z == sample.grid.nz - 1) found.kappa_within_at_seen_face += share * sample.grid.nz;
      }
    }
  }
  std::printf(
      "seed %d: weight %.3g, valley %.2g; within two deviations %.0f %% of kappa (%.0f %% at "
      "the seen face), %.0f %% of mu\n",
      static_cast<int>(seed), fit.report.weight, valley, 100.0 * found.kappa_within,
      100.0 * found.kappa_within_at_seen_face, 100.0 * found.mu_within);
  return found;
}

// With the fit's own weight as the prior of both coefficients 15 % of mu lay within two deviations.
TEST(Coverage, TheTruthOfABlockThatHardlyAbsorbsIsWithinWhatIsStated) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Found found = coverage_of({"tiny", 3, "reference"}, seed);
    EXPECT_GT(found.kappa_within, 0.9) << "seed " << seed;
    EXPECT_GT(found.mu_within, 0.9) << "seed " << seed;
  }
}

// By C alone 58, 36 and 49 % of κ at the seen face were within two deviations.
TEST(Coverage, TheTruthsOfBlocksOfSeveralGridsAreWithinWhatIsStated) {
  constexpr std::array seeds{21, 22, 23, 24};
  Found mean;
  for (const int seed : seeds) {
    const Found found = coverage_of({"demo", 4, "auto"}, static_cast<std::uint64_t>(seed));
    mean.kappa_within += found.kappa_within / seeds.size();
    mean.mu_within += found.mu_within / seeds.size();
    mean.kappa_within_at_seen_face += found.kappa_within_at_seen_face / seeds.size();
  }
  EXPECT_GT(mean.kappa_within, 0.9);
  EXPECT_NEAR(mean.mu_within, 0.94, 0.05);
  EXPECT_GT(mean.kappa_within_at_seen_face, 0.9);
}

}  // namespace
}  // namespace kappamu::synthetic
