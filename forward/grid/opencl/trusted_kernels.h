// Kernels of a solver for every number of lanes, each tested before its first use.
#pragma once

#include <map>

#include "device/context.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"
#include "forward/grid/opencl/opencl_solver.h"

namespace kappamu::forward {

class TrustedKernels {
 public:
  TrustedKernels(device::Context& context, const Format& format, Layout layout,
                 const OpenclOptions& options);

  /// Throws DeviceError when they fail their known-answer test.
  const LaneKernels& operator()(int lanes);

 private:
  device::Context& context_;
  Format format_;
  Layout layout_;
  OpenclOptions options_;
  std::map<int, LaneKernels> made_;
};

}  // namespace kappamu::forward
