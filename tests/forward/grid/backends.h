// The backends every law is tried on.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "device/device_info.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward::testing {

struct Backend {
  const char* name;
  const char* device;
  Precision precision;
  double rounding;  ///< relative error of a handful of operations in storage precision
};
inline constexpr Backend reference_backend{"Reference", "reference", Precision::double_precision,
                                           1e-13};
inline constexpr Backend opencl_single{"OpenclSingle", "auto", Precision::single_precision, 1e-6};
inline constexpr Backend opencl_double{"OpenclDouble", "auto", Precision::double_precision, 1e-13};

inline void PrintTo(const Backend& backend, std::ostream* out) {
  *out << backend.name;
}

/// Tests taking a backend; skipped where it has no device.
class OnBackend : public ::testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (std::string(GetParam().device) != "reference" && device::list_devices().empty()) {
      GTEST_SKIP() << "no OpenCL device is installed";
    }
  }
  static std::unique_ptr<GridSolver> solver(const GridSetup& setup) {
    SolverChoice choice = make_grid_solver(setup, GetParam().device, GetParam().precision);
    EXPECT_EQ(choice.warning, "");
    return std::move(choice.solver);
  }
  static bool single() { return GetParam().precision == Precision::single_precision; }
  static double rounding() { return GetParam().rounding; }
};

inline std::string backend_name(const ::testing::TestParamInfo<Backend>& info) {
  return info.param.name;
}

}  // namespace kappamu::forward::testing
