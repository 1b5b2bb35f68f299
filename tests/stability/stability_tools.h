// Shared by the stability tests: the device they need, and closed forms.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "device/device_info.h"
#include "tests/cases/limit_case.h"

namespace kappamu::test_cases::testing {

class OnDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }
};

/// φ of each layer of a stack between mirrors, even light on z- under the boundary source, no
/// absorption: half voxels and the two surfaces are resistances in series. The grid's equations
/// give exactly this at any κ.
inline std::vector<double> series_fluence(const Volume<double>& kappa, double robin_A, double q) {
  const GridShape& s = kappa.shape();
  const double h = s.voxel_mm;
  double resistance = 4.0 * robin_A;
  for (int z = 0; z < s.nz; ++z) resistance += h / kappa(0, 0, z);
  const double flux = q / resistance;
  std::vector<double> phi(s.cells());
  // From the dark side, where φ is smallest: no cancellation.
  double value = flux * 2.0 * robin_A;
  for (int z = s.nz - 1; z >= 0; --z) {
    value += flux * h / (2.0 * kappa(0, 0, z));
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) phi[s.index(x, y, z)] = value;
    }
    value += flux * h / (2.0 * kappa(0, 0, z));
  }
  return phi;
}

}  // namespace kappamu::test_cases::testing
