// Shared by the tests of Monte Carlo transport: homogeneous blocks, infinite slabs, and the
// statistics that say when two estimates agree.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "device/device_info.h"
#include "forward/montecarlo/monte_carlo_model.h"
#include "forward/montecarlo/photon_tracer.h"

namespace kappamu::forward::testing {

/// Skips tests that need an OpenCL device where there is none.
class WithDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }
  static device::Context& context() { return device::Context::chosen("auto"); }
};

/// Coefficients per mm.
inline Medium homogeneous(const GridShape& shape, double absorption, double reduced_scattering) {
  return {Volume<double>(shape, 1.0 / (3.0 * (absorption + reduced_scattering))),
          Volume<double>(shape, absorption)};
}

/// An infinite slab: one voxel between mirrors, evenly lit from z-. `scattering` is σs itself, not
/// the reduced one. Per mm.
struct Slab {
  double absorption, scattering, anisotropy, thickness_mm, eta;
};
struct SlabLight {  // per power that entered
  double reflected = 0.0, transmitted = 0.0, unscattered = 0.0, absorbed = 0.0;
  double reflected_error = 0.0, transmitted_error = 0.0;  ///< standard errors
  double cone = 0.0, cone_error = 0.0;                    ///< reflected within 10° of the normal
};
inline SlabLight trace_slab(device::Context& context, const Slab& slab, std::uint64_t photons,
                            SourceModel source = SourceModel::first_collision) {
  GridSetup setup;
  setup.shape = {1, 1, 1, slab.thickness_mm};
  setup.eta = slab.eta;
  setup.sides = Sides::mirror;
  setup.source = source;
  Progress silent;
  TraceOptions options;
  options.photons = photons;
  options.anisotropy = slab.anisotropy;
  const std::vector<double> light{1.0};
  const PhotonTally tally = trace_photons(
      context, setup,
      homogeneous(setup.shape, slab.absorption, slab.scattering * (1.0 - slab.anisotropy)), light,
      1, options, silent);
  const Score& front = tally.exits[first_pixel(setup.shape, Face::z_minus)];
  const Score& back = tally.exits[first_pixel(setup.shape, Face::z_plus)];
  const Score& cone = tally.totals[0].cone[static_cast<std::size_t>(Face::z_minus)];
  const double all = Score::full_weight * static_cast<double>(photons);
  SlabLight result;
  result.reflected = front.mean(photons);
  result.reflected_error = front.standard_error(photons);
  result.transmitted = back.mean(photons);
  result.transmitted_error = back.standard_error(photons);
  result.unscattered = static_cast<double>(tally.totals[0].unscattered) / all;
  result.absorbed = static_cast<double>(tally.totals[0].absorbed) / all;
  result.cone = cone.mean(photons);
  result.cone_error = cone.standard_error(photons);
  return result;
}

/// Σ of squared differences over their variances; what a χ² test needs.
struct ChiSquare {
  double sum = 0.0;
  int count = 0;

  void add(double difference, double standard_error) {
    sum += difference * difference / (standard_error * standard_error);
    ++count;
  }
  /// Sum over count is 1 within three standard deviations of χ² (√(2/count)), and within what the
  /// skewness of few photons per pixel adds: estimated variances are low where the estimate is.
  ::testing::AssertionResult holds(double fewest_photons) const {
    const double ratio = sum / count;
    const double bound = 3.0 * std::sqrt(2.0 / count) + 3.0 / fewest_photons;
    if (std::abs(ratio - 1.0) <= bound) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure()
           << "chi square per sample " << ratio << " of " << count << ", allowed 1 +- " << bound;
  }
};

}  // namespace kappamu::forward::testing
