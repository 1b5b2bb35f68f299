// Whether the truth lies within what a fit states: small structured blocks whose light is
// diffusion's on a finer grid, so that nothing but noise, smoothing and the grid stands between fit
// and truth.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "core/progress.h"
#include "data_synthetic/scene/materials.h"
#include "data_synthetic/score.h"
#include "inverse/fit/fit.h"
#include "inverse/fit/fit_uncertainty.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::synthetic {
namespace {

struct Found {
  Coverage kappa, mu;
  /// Root mean square error of log μ against what is resolved, over that against the truth itself.
  double mu_nearer = 0.0;
};

struct Setup {
  const char* sample;
  int patches;  ///< along either axis of the lit face
  const char* device;
};

double log_error(const Volume<double>& found, const Volume<double>& truth) {
  double squares = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    squares += std::pow(std::log(found[i] / truth[i]), 2);
  }
  return std::sqrt(squares / static_cast<double>(found.size()));
}

/// The red coefficients at 1 % noise.
Found coverage_of(const Setup& setup, std::uint64_t seed) {
  const SampleModel sample = make_sample(setup.sample, seed);
  test_cases::Block block;
  block.grid = sample.grid;
  const GridShape finer = sample.grid.refined(2);
  const Medium truth = sample_medium(sample, finer)[0];
  const inverse::CoefficientPair logs = inverse::to_fields(truth);
  inverse::FitOptions options;
  options.path.model = inverse::Model::volume;
  options.uncertainty.probes = inverse::usual_probes;
  options.solver.backend.device = setup.device;
  Progress silent;
  const SurfaceMeasurements measured = test_cases::measure(block, logs, setup.patches, seed);
  const inverse::ChannelFit fit =
      inverse::fit_channel(measured, 0, options, inverse::Checkpoint{}, silent);
  const inverse::SharedDeviation shared = inverse::shared_deviation({&fit, 1}, measured.lit_face);
  const inverse::Uncertainty stated = inverse::estimate_volume_uncertainty(fit, shared, measured);
  std::vector<double> of_kappa, of_mu;
  for (const inverse::LayerUncertainty& layer : stated.report.layers) {
    of_kappa.push_back(layer.kappa_fwhm_mm);
    of_mu.push_back(layer.mu_fwhm_mm);
  }
  const Volume<double> kappa =
      resolved(average_volume(truth.kappa, sample.grid), block.seen, of_kappa);
  const Volume<double> mu_itself = average_volume(truth.mu, sample.grid);
  const Volume<double> mu = resolved(mu_itself, block.seen, of_mu);
  const auto covered = [&](const Volume<double>& found, const Volume<double>& of_truth,
                           const Volume<float>& log_deviation) {
    return coverage(found, of_truth,
                    {sample.grid, {log_deviation.values().begin(), log_deviation.values().end()}},
                    block.lit);
  };
  const Found found{covered(fit.medium.kappa, kappa, stated.log_kappa_std),
                    covered(fit.medium.mu, mu, stated.log_mu_std),
                    log_error(fit.medium.mu, mu) / log_error(fit.medium.mu, mu_itself)};
  std::printf(
      "seed %d: weight %.3g, shared %.2g; within two deviations %.0f %% of kappa (%.0f %% at "
      "the seen face), %.0f %% of mu; error of mu %.2f of that against the truth itself\n",
      static_cast<int>(seed), fit.report.weight, shared.log_kappa, 100.0 * found.kappa.within_two,
      100.0 * found.kappa.within_two_by_depth.back(), 100.0 * found.mu.within_two, found.mu_nearer);
  return found;
}

// With the fit's own weight as the prior of both coefficients 15 % of mu lay within two deviations.
TEST(Coverage, TheTruthOfABlockThatHardlyAbsorbsIsWithinWhatIsStated) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Found found = coverage_of({"tiny", 3, "reference"}, seed);
    EXPECT_GT(found.kappa.within_two, 0.9) << "seed " << seed;
    EXPECT_GT(found.mu.within_two, 0.9) << "seed " << seed;
  }
}

// By C alone 58, 36 and 49 % of κ at the seen face were within two deviations.
TEST(Coverage, TheTruthsOfBlocksOfSeveralGridsAreWithinWhatIsStated) {
  constexpr std::array seeds{21, 22, 23, 24};
  double kappa = 0.0, kappa_at_seen_face = 0.0, mu = 0.0, mu_nearer = 0.0;
  double kappa_median = 0.0, mu_median = 0.0;
  for (const int seed : seeds) {
    const Found found = coverage_of({"demo", 4, "auto"}, static_cast<std::uint64_t>(seed));
    kappa += found.kappa.within_two / seeds.size();
    kappa_at_seen_face += found.kappa.within_two_by_depth.back() / seeds.size();
    mu += found.mu.within_two / seeds.size();
    mu_nearer += found.mu_nearer / seeds.size();
    kappa_median += found.kappa.median / seeds.size();
    mu_median += found.mu.median / seeds.size();
  }
  EXPECT_GT(kappa, 0.9);
  EXPECT_GT(mu, 0.9);
  EXPECT_GT(kappa_at_seen_face, 0.9);
  // 0.67 if errors were as stated; what is stated must not be wide for nothing.
  EXPECT_GT(kappa_median, 0.15);
  EXPECT_GT(mu_median, 0.4);
  EXPECT_LT(mu_nearer, 0.8) << "the fit is of means of about the width that it states";
}

}  // namespace
}  // namespace kappamu::synthetic
