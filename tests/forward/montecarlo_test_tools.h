// Shared by the tests of Monte Carlo transport: homogeneous blocks, and one-line solves.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
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
  static device::Context& context() {
    return device::Context::of(device::choose(device::list_devices(), "auto").index);
  }
};

/// Coefficients per mm.
inline Medium homogeneous(const GridShape& shape, double absorption, double reduced_scattering) {
  return {Volume<double>(shape, 1.0 / (3.0 * (absorption + reduced_scattering))),
          Volume<double>(shape, absorption)};
}

/// An infinite slab: one column of voxels between mirrors, evenly lit from z-. `scattering` is σs
/// itself, not the reduced one.
struct Slab {
  double absorption, scattering, anisotropy, thickness_mm, eta;
};
struct SlabLight {
  double reflected, transmitted, unscattered, absorbed;  // per entering power
  double reflected_error, transmitted_error;             // standard errors
};
inline SlabLight trace_slab(device::Context& context, const Slab& slab, std::uint64_t photons,
                            std::uint64_t seed, SourceModel source = SourceModel::first_collision) {
  GridSetup setup;
  setup.shape = {1, 1, 1, slab.thickness_mm};
  setup.eta = slab.eta;
  setup.sides = Sides::mirror;
  setup.source = source;
  Progress silent;
  TraceOptions options;
  options.photons = photons;
  options.seed = seed;
  options.anisotropy = slab.anisotropy;
  const std::vector<double> light{1.0};
  const PhotonTally tally = trace_photons(
      context, setup,
      homogeneous(setup.shape, slab.absorption, slab.scattering * (1.0 - slab.anisotropy)), light,
      1, options, silent);
  const Score& front = tally.exits[first_pixel(setup.shape, Face::z_minus)];
  const Score& back = tally.exits[first_pixel(setup.shape, Face::z_plus)];
  const double all = Score::full_weight * static_cast<double>(photons);
  return {front.mean(photons),
          back.mean(photons),
          static_cast<double>(tally.totals[0].unscattered) / all,
          static_cast<double>(tally.totals[0].absorbed) / all,
          front.standard_error(photons),
          back.standard_error(photons)};
}

}  // namespace kappamu::forward::testing
