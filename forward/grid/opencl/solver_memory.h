// What the OpenCL solver will need of its device, known before anything is allocated.
#pragma once

#include <cstddef>

#include "device/device_info.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"

namespace kappamu::forward {

/// Bytes on the device for the medium and all levels, the work space for `lanes` patterns at once,
/// and `fields` batches of `patterns` volumes (right-hand side and solution are 2).
std::size_t solver_memory(const GridSetup& setup, int patterns, int fields, int lanes,
                          const Format& format, Layout layout);

/// The same for a processor, with room for `at_once` patterns or for more: those that fit a vector.
std::size_t solver_memory(const GridSetup& setup, int patterns, int fields, int at_once,
                          Precision precision);

/// The most patterns at once (16, 8, 4 or 1) with which b, φ, λ and the work space fit the device.
/// Throws InputError stating need and memory where not even one does.
int lanes_that_fit(const GridSetup& setup, const device::DeviceInfo& device, const Format& format,
                   Layout layout);

}  // namespace kappamu::forward
