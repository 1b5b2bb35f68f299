// What both backends of GridSolver say of a solve that has ended.
#pragma once

#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Sets termination and message of `report` from its residuals and iterations; `stagnated`:
/// rounding stopped it, not the bound on iterations.
void conclude(SolveReport& report, double tolerance, bool stagnated, Precision precision);

}  // namespace kappamu::forward
