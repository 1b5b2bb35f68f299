// Coefficients of a slab from its totals: those the totals were made from. The measured slabs
// themselves are docs/validity.md's.
#include "studies/forward/slab_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "studies/forward/slabs.h"

namespace kappamu::studies {
namespace {

MeasuredSlab intralipid() {
  MeasuredSlab slab;
  slab.n_sample = 1.33;
  slab.n_slide = 1.5;
  slab.thickness = 1.0;
  slab.sigma_a = 0.15;
  slab.sigma_s_prime = 1.0;
  slab.anisotropy = 0.5;
  return slab;
}

TEST(SlabFit, DiffusionsTotalsGiveDiffusionsCoefficients) {
  MeasuredSlab slab = intralipid();
  const SlabPrediction totals = slab_by_diffusion(slab);
  slab.reflectance = totals.reflectance;
  slab.transmittance = totals.transmittance;
  const SlabCoefficients found = fit_by_diffusion(slab);
  EXPECT_TRUE(found.settled);
  EXPECT_NEAR(found.sigma_a / slab.sigma_a, 1.0, 1e-3);
  EXPECT_NEAR(found.sigma_s_prime / slab.sigma_s_prime, 1.0, 1e-3);
}

// An albedo of 0.87, 1.15 mean free paths thick.
TEST(SlabFit, TransportsTotalsGiveTransportsCoefficientsWithinTheirDeviations) {
  MeasuredSlab slab = intralipid();
  constexpr std::uint64_t data_seed = 77, fit_seed = 1, photons = 20'000;
  const SlabPrediction totals = slab_by_photons(slab, 10 * photons, data_seed);
  slab.reflectance = totals.reflectance;
  slab.transmittance = totals.transmittance;
  const double data_error = std::max(totals.reflectance_error, totals.transmittance_error);
  const SlabCoefficients start = fit_by_diffusion(slab);
  EXPECT_GT(std::abs(start.sigma_a / slab.sigma_a - 1.0), 0.2);
  const SlabCoefficients found = fit_by_transport(slab, start, data_error, photons, fit_seed);
  EXPECT_TRUE(found.settled);
  constexpr double deviations = 3.0;
  EXPECT_LT(std::abs(std::log(found.sigma_a / slab.sigma_a)), deviations * found.log_sigma_a_std);
  EXPECT_LT(std::abs(std::log(found.sigma_s_prime / slab.sigma_s_prime)),
            deviations * found.log_sigma_s_std);
  EXPECT_LT(found.log_sigma_a_std, 0.1);
}

}  // namespace
}  // namespace kappamu::studies
