// First collisions of a beam (grid_beam.cl): the share of the light that enters a column of the lit
// face which each of its voxels scatters first.
#pragma once

#include "device/context.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"

namespace kappamu::forward {

/// Sets `share` [z][y][x] from κ and μ, all in the solver's numbers.
void deposit_beam(device::Context& context, const Format& format, Layout layout,
                  const GridSetup& setup, const device::Buffer& kappa, const device::Buffer& mu,
                  const device::Buffer& share);

}  // namespace kappamu::forward
