// The solver in OpenCL: conjugate gradients on the matrix by rows, preconditioned by one V-cycle on
// aggregates (equations/hierarchy.h). Fields stay on the device, lights and channels are the lanes
// of vectors; only sums are read. Equal input gives equal bits.
#pragma once

#include <optional>

#include "forward/linear/opencl/device_lanes.h"
#include "forward/polygrid/linear_solver.h"

namespace kappamu::forward::polygrid {

/// `twofold` is for tests of the kernels, and for residuals below 1e-6.
using linear::Precision;

/// Keeps references to all three. `form`: the kernels as that kind of device has them; none: its
/// own. Throws InputError where memory is too little or the device lacks double precision that is
/// asked for. Sums are in double where the device has it.
std::unique_ptr<LinearSolver> make_opencl_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 device::Context& context, Precision precision,
                                                 Lights lights = Lights::others,
                                                 std::optional<device::Kind> form = {});

}  // namespace kappamu::forward::polygrid
