// The linear solver of assembled equations: conjugate gradients preconditioned by one V-cycle, on
// the host's threads or on an OpenCL device. Lights of one medium, or one light of each of several
// media, are solved for together.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "device/context.h"
#include "forward/linear/lanes.h"
#include "forward/linear/v_cycle.h"

namespace kappamu::forward::linear {

/// What the model gives: the levels of the media of some lanes, Lanes::media() numbers per value,
/// zero in lanes that are not used.
using Assembly = std::function<RowLevels(const Lanes&)>;

std::unique_ptr<LinearSolver> make_host_solver(Assembly assembly);

/// Fields stay on the device from the right-hand side to the solution. Keeps a reference to the
/// context. Throws InputError where the device has no double precision or too little memory.
/// `slice`: rows whose entries lie together (rows.cl), more than one as on a GPU, whose sums go
/// through rows in turn; none: as suits the device.
std::unique_ptr<LinearSolver> make_opencl_solver(Assembly assembly, device::Context& context,
                                                 std::optional<std::size_t> slice = {});

}  // namespace kappamu::forward::linear
