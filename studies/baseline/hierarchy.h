// [W] 5.3: the multiresolution grid. Coarse coefficients are means over children; the coarsest
// problem is solved first, and each solution copied to the children starts the next finer one. The
// adaptive scheme moreover leaves cells deep below the surface as copied.
#pragma once

#include <string>
#include <vector>

#include "studies/baseline/relaxation.h"

namespace kappamu::studies::baseline {

using namespace forward;

struct HierarchyOptions {
  int levels = 1;  ///< at most; 1: the given grid alone
  Active active;   ///< cells updated on all levels but the coarsest, which updates all
};

/// Levels until a single cell is left along every axis.
inline constexpr int all_levels = 32;

class CoarseToFine {
 public:
  CoarseToFine(const Batch& batch, const GridSetup& setup, double robin_A, const Medium& medium,
               const HierarchyOptions& options);

  struct Result {
    Relaxed finest;
    std::vector<int> coarse_sweeps;  ///< coarsest first
  };
  /// φ for b, both on the finest grid; `batch` may have other lanes than the constructor's, but the
  /// same device and precision.
  Result solve(const Batch& batch, const device::Buffer& b, device::Buffer& phi, Relaxation kind,
               const SolveOptions& options) const;

 private:
  struct Level {
    DeviceStencil stencil;
    device::Buffer light_scale;  ///< of the sum over children's b; empty on the finest
  };
  Active active_;
  std::vector<Level> levels_;  ///< finest first
};

}  // namespace kappamu::studies::baseline
