// Where a medium is beyond what diffusion, or its grid, describes well: sentences for the user.
#pragma once

#include <string>
#include <vector>

#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Diffusion's own error at the block's mean coefficients (analytic/validity.h), voxels that absorb
/// strongly, voxels beyond the mean free path, light falling beyond the tolerance; empty where all
/// is well. `precision` is the solve's: what is already double is not advised.
std::vector<std::string> diffusion_warnings(const GridSetup& setup, const Medium& medium,
                                            Precision precision);

}  // namespace kappamu::forward
