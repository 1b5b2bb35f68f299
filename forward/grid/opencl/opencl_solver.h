// The OpenCL backend of GridSolver.
#pragma once

#include <memory>
#include <optional>

#include "device/context.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"

namespace kappamu::forward {

/// Patterns solved at once where memory allows.
inline constexpr int full_lanes = 16;

enum class Trust {
  verify,  ///< kernels for a number of lanes pass solver_verdict() before their first use
  blind    ///< for that test itself
};

struct OpenclOptions {
  Precision precision = Precision::single_precision;
  Trust trust = Trust::verify;
  /// Instead of the device's own, to test one on the other's device.
  std::optional<Layout> layout = {};
  /// Patterns at once (16, 8, 4 or 1) where memory allows more.
  std::optional<int> most_lanes = {};
};

/// Throws InputError when the device lacks memory for the grid or double precision where asked,
/// DeviceError when its compiler fails or, on use, when kernels fail their known-answer test.
std::unique_ptr<GridSolver> make_opencl_solver(const GridSetup& setup, device::Context& context,
                                               const OpenclOptions& options);

}  // namespace kappamu::forward
