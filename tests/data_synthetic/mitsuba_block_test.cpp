// A block photographed by Mitsuba 3 (tests/data/mitsuba-block/SOURCE.md): another program's random
// walk through another program's glass, merged by `kappamu run`, is fitted blind.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "device/device_info.h"
#include "inverse/fit/fit_uncertainty.h"
#include "inverse/problem/predict.h"
#include "inverse/validation/validated_fit.h"
#include "inverse/validation/validation_patterns.h"
#include "io/measurements_file.h"
#include "io/npy.h"
#include "tests/reference_data.h"

namespace kappamu::synthetic {
namespace {

Volume<double> read_volume(const std::string& name, const GridShape& shape) {
  const std::vector<float> values = io::read_npy(reference_data("mitsuba-block") / name).values;
  return {shape, {values.begin(), values.end()}};
}

/// Share of voxels whose logarithm is within two of its stated deviations.
double within_two(const Volume<double>& found, const Volume<double>& truth,
                  const Volume<float>& log_deviation) {
  double count = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (std::abs(std::log(found[i] / truth[i])) <= 2.0 * log_deviation[i]) count += 1.0;
  }
  return count / static_cast<double>(truth.size());
}

class MitsubaBlock : public ::testing::Test {
 protected:
  MitsubaBlock() { options_.solver.backend.device = "reference"; }

  const std::filesystem::path folder_ = reference_data("mitsuba-block");
  const SurfaceMeasurements fitted_ = io::read_measurements(folder_ / "measurements");
  const SurfaceMeasurements held_ = io::read_measurements(folder_ / "measurements_validate");
  const Medium truth_{read_volume("kappa_Y.npy", fitted_.grid),
                      read_volume("mu_Y.npy", fitted_.grid)};
  inverse::FitOptions options_;
};

TEST_F(MitsubaBlock, TrueVolumePredictsItsLight) {
  const inverse::ValidationScore score = inverse::validation_score(
      truth_, fitted_, 0, inverse::predict_options(options_, inverse::Physics::diffusion),
      options_.data.model_error, options_.data.term);
  double predicted = 0.0, measured = 0.0;
  for (const float value : score.prediction) predicted += value;
  for (const float value : fitted_.value) measured += value;
  std::printf("light of all patterns, diffusion over Mitsuba %.4f, E %.2e\n", predicted / measured,
              score.error.E());
  EXPECT_NEAR(predicted / measured, 1.0, 0.03);  // 1.005; our Monte Carlo: 1.004
  EXPECT_LT(score.error.E(), 2.5e-2);            // 1.9e-2; our Monte Carlo: 7e-3
}

/// Photons know where a camera stands: the exitance of a face, spread by the P1 law, is not what it
/// sees.
TEST_F(MitsubaBlock, TrueVolumePredictsWhatCamerasSeeByTransport) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  options_.solver.backend.device = "auto";
  for (const char* view : {"", "oblique"}) {
    SCOPED_TRACE(view);
    const SurfaceMeasurements seen = io::read_measurements(folder_ / view / "measurements");
    ASSERT_EQ(seen.cameras.count(Face::z_plus), 1);
    const auto error = [&](const SurfaceMeasurements& measured) {
      const inverse::ValidationScore score = inverse::validation_score(
          truth_, measured, 0, inverse::predict_options(options_, inverse::Physics::transport),
          options_.data.model_error, options_.data.term);
      double predicted = 0.0, all = 0.0;
      for (const float value : score.prediction) predicted += value;
      for (const float value : measured.value) all += value;
      std::printf("%s: light, ours over Mitsuba's, %.4f, E %.2e (noise %.2e)\n",
                  measured.cameras.empty() ? "exitance" : "camera", predicted / all,
                  score.error.E(), score.error.noise_E());
      return score.error;
    };
    SurfaceMeasurements without = seen;
    without.cameras.clear();
    const AppearanceError camera = error(seen), exitance = error(without);
    EXPECT_LT(camera.E(), 0.5 * exitance.E());
    EXPECT_LT(camera.E(), 1.5 * camera.noise_E());
  }
}

TEST_F(MitsubaBlock, FittedBlindItPredictsOtherLightAndStatesItsErrors) {
  options_.uncertainty.probes = inverse::usual_probes;
  Progress silent;
  const inverse::ValidatedFit found = inverse::fit_validated(
      inverse::split_validation(fitted_, {}, held_), 0, options_, {}, {}, silent);
  const AppearanceError& error = found.score->error;
  ASSERT_TRUE(found.fit.prior.has_value());  // a volume
  const inverse::Uncertainty stated = inverse::estimate_volume_uncertainty(
      found.fit, inverse::shared_deviation({&found.fit, 1}, fitted_.lit_face), fitted_);
  const double kappa = within_two(found.fit.medium.kappa, truth_.kappa, stated.log_kappa_std);
  const double mu = within_two(found.fit.medium.mu, truth_.mu, stated.log_mu_std);
  std::printf("patterns held out: E %.2e (noise %.2e), within two deviations %.2f, %.2f\n",
              error.E(), error.noise_E(), kappa, mu);
  EXPECT_LT(error.E(), error.noise_E());
  EXPECT_GT(kappa, 0.95);
  EXPECT_GT(mu, 0.95);
}

}  // namespace
}  // namespace kappamu::synthetic
