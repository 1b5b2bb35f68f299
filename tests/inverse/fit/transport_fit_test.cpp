// A fit whose r carries transport's answer: its gradient, where it ends, how soon, and that it goes
// on from a checkpoint to the same bits. Data are Monte Carlo's with seeds that the fit does not
// draw.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "device/device_info.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/fit/fit_uncertainty.h"
#include "tests/cases/limit_inverse_case.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

class TransportFit : public ::testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }
};

/// A block of voxels of half a mean free path, under 2 × 2 patches.
test_cases::Block small_block(int depth, double noise) {
  test_cases::Block block;
  block.grid = {8, 8, depth, 0.3};
  block.noise = noise;
  return block;
}

/// Monte Carlo's data with noise, and their own.
SurfaceMeasurements photons_of(const test_cases::Block& block, const test_cases::Figure3& truth,
                               std::uint64_t seed, double anisotropy = 0.0) {
  SurfaceMeasurements m = test_cases::expose_photons(block, truth, 2, seed, anisotropy);
  const std::vector<float> own = m.variance;
  test_cases::spoil(m, block.noise, {}, seed);
  for (std::size_t i = 0; i < own.size(); ++i) m.variance[i] += own[i];
  return m;
}

FitOptions by(Physics physics, Model model = Model::homogeneous) {
  FitOptions options;
  options.data.physics = physics;
  options.path.model = model;
  return options;
}

/// r of photons with its slope, made at `at`.
Objective objective_of(const SurfaceMeasurements& m, const CoefficientPair& at) {
  Backend backend;
  backend.precision = forward::Precision::double_precision;
  backend.solve = {1e-12, 2000};
  Objective objective(make_problem(m, 0, forward::Convention::physical, {}), backend);
  Refinement finer = refine(objective.problem());
  finer.photons = PhotonOptions{};
  objective.refresh_correction(finer, at, Objective::PhotonSlope::renewed);
  return objective;
}

TEST_F(TransportFit, GradientIsThatOfTheObjectiveWithRsSlope) {
  const test_cases::Block block = small_block(4, 0.03);
  const SurfaceMeasurements m = photons_of(block, test_cases::even_block(0.2, 0.01), 11);
  const CoefficientPair at = cases::rough_medium(block.grid, 0.2, 3);
  Objective objective = objective_of(m, at);
  const double value = objective.value(at);
  EXPECT_GT(objective.solves().photons, 0.0);
  const CoefficientPair gradient = objective.gradient();
  CoefficientPair direction = cases::random_direction(block.grid, 4);
  for (double& x : direction.log_kappa) x += 0.5;  // even too
  double slope = 0.0;
  for (std::size_t i = 0; i < block.grid.cells(); ++i) {
    slope +=
        gradient.log_kappa[i] * direction.log_kappa[i] + gradient.log_mu[i] * direction.log_mu[i];
  }
  const std::vector<double> tangent = objective.jacobian(direction);
  std::vector<double> probe(tangent.size());
  for (std::size_t i = 0; i < probe.size(); ++i) probe[i] = std::sin(static_cast<double>(i));
  const CoefficientPair transposed = objective.jacobian_transpose(probe);
  double forward = 0.0, back = 0.0;
  for (std::size_t i = 0; i < probe.size(); ++i) forward += probe[i] * tangent[i];
  for (std::size_t i = 0; i < block.grid.cells(); ++i) {
    back += transposed.log_kappa[i] * direction.log_kappa[i] +
            transposed.log_mu[i] * direction.log_mu[i];
  }
  EXPECT_NEAR(forward / back, 1.0, 1e-8);
  std::vector<double> remainder;
  for (const double step : {0.02, 0.01, 0.005}) {
    CoefficientPair moved = at;
    for (std::size_t i = 0; i < block.grid.cells(); ++i) {
      moved.log_kappa[i] += step * direction.log_kappa[i];
      moved.log_mu[i] += step * direction.log_mu[i];
    }
    remainder.push_back(std::abs(objective.value(moved) - value - step * slope));
  }
  for (std::size_t k = 1; k < remainder.size(); ++k) {
    EXPECT_NEAR(std::log2(remainder[k - 1] / remainder[k]), 2.0, 0.15);
  }
}

/// Errors of a homogeneous fit in stated deviations.
struct Score {
  double kappa = 0.0, mu = 0.0;                ///< found over true − 1
  double kappa_in_std = 0.0, mu_in_std = 0.0;  ///< log found − log true over its stated deviation
};

Score score(const ChannelFit& fit, const SurfaceMeasurements& m, const FitOptions& options,
            double kappa, double mu) {
  const Uncertainty stated = estimate_model_uncertainty(fit, m, 0, options);
  const double of_kappa = std::log(fit.medium.kappa[0] / kappa);
  const double of_mu = std::log(fit.medium.mu[0] / mu);
  return {std::expm1(of_kappa), std::expm1(of_mu), of_kappa / stated.log_kappa_std[0],
          of_mu / stated.log_mu_std[0]};
}

/// Within two of its stated deviations of the truth, and those of a size worth stating.
void expect_truth(const test_cases::Block& block, double kappa, double mu, std::uint64_t seed) {
  const SurfaceMeasurements m = photons_of(block, test_cases::even_block(kappa, mu), seed);
  const FitOptions options = by(Physics::transport);
  const ChannelFit fit = cases::fit(m, options);
  const Score found = score(fit, m, options, kappa, mu);
  EXPECT_LT(std::abs(found.kappa_in_std), 2.0) << found.kappa;
  EXPECT_LT(std::abs(found.mu_in_std), 2.0) << found.mu;
  EXPECT_LT(std::abs(found.kappa), 0.05);
  EXPECT_LT(std::abs(found.mu), 0.15);
  EXPECT_EQ(fit.report.status, FitStatus::converged) << fit.report.reason;
}

// Two mean free paths thick: by diffusion κ is 20 % and μ 46 % off.
TEST_F(TransportFit, EndsAtTransportsCoefficientsOfAThinBlock) {
  expect_truth(small_block(4, 0.02), 0.2, 0.1, 21);
}

// The same by photons that scatter forwards: what isotropic scattering takes for less absorption.
TEST_F(TransportFit, EndsAtTheCoefficientsOfAnisotropicTransport) {
  const test_cases::Block block = small_block(4, 0.02);
  constexpr double kappa = 0.2, mu = 0.1, g = 0.8;
  const SurfaceMeasurements m = photons_of(block, test_cases::even_block(kappa, mu), 25, g);
  FitOptions options = by(Physics::transport);
  options.data.anisotropy = g;
  const Score found = score(cases::fit(m, options), m, options, kappa, mu);
  EXPECT_LT(std::abs(found.kappa_in_std), 2.0) << found.kappa;
  EXPECT_LT(std::abs(found.mu_in_std), 2.0) << found.mu;
  options.data.anisotropy = 0.0;
  const Score isotropic = score(cases::fit(m, options), m, options, kappa, mu);
  EXPECT_GT(std::abs(isotropic.mu), 2.0 * std::abs(found.mu)) << isotropic.mu;
  options.data.physics = Physics::diffusion;
  options.data.anisotropy = g;
  EXPECT_THROW(validate(options), InputError);
}

// 3κμ = 0.3 at 3.6 and 2.7 mean free paths, where the iteration leaves the truth (κ 140 % off) if r
// is constant between its renewals.
TEST_F(TransportFit, EndsAtTransportsCoefficientsOfAnAbsorbingBlock) {
  test_cases::Block block = small_block(8, 0.02);
  block.grid.voxel_mm = 0.4;
  expect_truth(block, 0.3, 0.33, 22);
}

TEST_F(TransportFit, EndsAtTransportsCoefficientsOfAThinnerAbsorbingBlock) {
  test_cases::Block block = small_block(6, 0.02);
  block.grid.voxel_mm = 0.4;
  expect_truth(block, 0.3, 0.33, 22);
}

// Few data of a thin block: the renewals of r may not settle, and then the fit says so.
TEST_F(TransportFit, EndsNearTheTruthOrSaysThatItHasNotSettled) {
  constexpr double kappa = 0.2, mu = 0.1;
  for (const unsigned seed : {23U, 31U}) {
    const test_cases::Block block = small_block(4, 0.02);
    const SurfaceMeasurements m = photons_of(block, test_cases::even_block(kappa, mu), seed);
    const FitReport report = cases::fit(m, by(Physics::transport, Model::homogeneous)).report;
    const bool told = std::any_of(report.warnings.begin(), report.warnings.end(),
                                  [](const std::string& sentence) {
                                    return sentence.find("not settled") != std::string::npos;
                                  });
    if (told) continue;
    EXPECT_NEAR(std::log(report.homogeneous_kappa / kappa), 0.0, 0.15) << seed;
    EXPECT_NEAR(std::log(report.homogeneous_mu / mu), 0.0, 0.4) << seed;
  }
}

// What passes a mean free path tells of g as much as of μ.
TEST(TransportWarnings, ABlockThatHardlyScattersIsNamed) {
  constexpr double kappa = 0.2;
  for (const bool thin : {true, false}) {
    test_cases::Block block = small_block(4, 0.02);
    block.grid.voxel_mm = (thin ? 3.0 : 6.0) * kappa / block.grid.nz;
    SurfaceMeasurements m;
    m.grid = block.grid;
    m.lit_face = block.lit;
    m.seen_face = block.seen;
    const Medium medium{Volume<double>(m.grid, kappa), Volume<double>(m.grid, 0.1)};
    FitReport report;
    report.physics = Physics::transport;
    const std::vector<std::string> warnings = volume_warnings(medium, report, m, {});
    if (thin) {
      EXPECT_THAT(warnings, ::testing::ElementsAre(::testing::HasSubstr("passes unscattered")));
    } else {
      EXPECT_THAT(warnings, ::testing::IsEmpty());
    }
  }
}

// Two mean free paths thick, where single pixels' noise would hide what diffusion is off by.
TEST_F(TransportFit, AutoTakesTransportWhereItFindsAnotherBlock) {
  const SurfaceMeasurements m =
      photons_of(small_block(4, 0.1), test_cases::even_block(0.2, 0.1), 25);
  const FitReport chosen = cases::fit(m, by(Physics::automatic)).report;
  const FitReport transport = cases::fit(m, by(Physics::transport)).report;
  EXPECT_EQ(chosen.physics, Physics::transport);
  EXPECT_EQ(chosen.homogeneous_kappa, transport.homogeneous_kappa);
  EXPECT_EQ(chosen.homogeneous_mu, transport.homogeneous_mu);
  EXPECT_THAT(chosen.physics_reason, ::testing::EndsWith("the fit is by transport."));
  EXPECT_TRUE(transport.physics_reason.empty()) << "nothing was to decide";
}

TEST_F(TransportFit, KilledAnywhereItEndsInTheSameBits) {
  const test_cases::Block block = small_block(8, 0.05);
  const SurfaceMeasurements m =
      photons_of(block, test_cases::structured_block(0.2, 0.05, 1.0, 1), 24);
  FitOptions options = by(Physics::transport, Model::volume);
  options.path.stage_steps = 3;
  const ChannelFit whole = cases::fit(m, options);
  EXPECT_EQ(whole.report.physics, Physics::transport);
  struct Killed {};
  std::vector<std::byte> saved;
  int kills = 0;
  ChannelFit resumed;
  for (bool finished = false; !finished;) {
    Checkpoint checkpoint;
    checkpoint.interval_seconds = 0.0;
    checkpoint.load = cases::once(saved);
    checkpoint.save = [&, saves = 0](std::span<const std::byte> bytes) mutable {
      saved.assign(bytes.begin(), bytes.end());
      if (++saves == 6) throw Killed{};
    };
    try {
      resumed = cases::fit(m, options, checkpoint);
      finished = true;
    } catch (const Killed&) {
      ++kills;
    }
  }
  EXPECT_GT(kills, 1);
  EXPECT_EQ(whole.medium.kappa.values(), resumed.medium.kappa.values());
  EXPECT_EQ(whole.medium.mu.values(), resumed.medium.mu.values());
  EXPECT_EQ(whole.prediction, resumed.prediction);
  EXPECT_EQ(whole.report.solves.photons, resumed.report.solves.photons);
}

TEST_F(TransportFit, NeedsTheGridCorrectionAndThePhysicalConvention) {
  FitOptions options = by(Physics::transport);
  options.path.correct_grid = false;
  EXPECT_THROW(validate(options), InputError);
  options = by(Physics::automatic);
  options.data.convention = forward::Convention::wang2008;
  EXPECT_THROW(validate(options), InputError);
}

}  // namespace
}  // namespace kappamu::inverse
