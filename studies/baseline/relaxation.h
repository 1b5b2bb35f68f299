// Relaxation on one grid: the papers' solver. Stam 1995 and [W] 5.2 keep two buffers and compute
// every new value from old ones (Jacobi); [T] 4.2.2 relaxes by Gauß-Seidel, here in red-black order
// so that lanes and cores can share it.
#pragma once

#include <vector>

#include "studies/baseline/batch.h"

namespace kappamu::studies::baseline {

using namespace forward;

enum class Relaxation { jacobi, gauss_seidel };

/// Which cells are updated: those fewer than `depth` cells from an open face.
struct Active {
  int depth = 0x40000000;  ///< beyond every extent: all
  std::array<bool, 3> open{true, true, true};
};

struct Relaxed {
  int sweeps = 0;
  bool converged = false;
  bool stalled = false;          ///< rounding undoes what more sweeps gain (docs/theory.md)
  double factor = 1.0;           ///< of the slowest pattern's residual per sweep, lately
  std::vector<double> residual;  ///< [pattern] ‖b − A φ‖ over active cells / ‖b‖ over all
};

/// Sweeps from `phi` until every pattern's relative residual is at most the tolerance; the residual
/// costs as much as a sweep and is computed after 8, 16, ... and then every 16th more sweeps, so
/// that it takes 6 % of the time and at most 6 % of the sweeps are idle.
Relaxed relax(const Batch& batch, Relaxation kind, const DeviceStencil& stencil,
              const Active& active, const device::Buffer& b, device::Buffer& phi,
              const SolveOptions& options);

/// One sentence about it: converged, ran out or stalled, and how far it is from there.
std::string sentence(const Relaxed& relaxed, double tolerance, Precision precision);

}  // namespace kappamu::studies::baseline
