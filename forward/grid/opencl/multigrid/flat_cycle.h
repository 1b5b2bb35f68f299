// The preconditioner of flat steps: the stream steps' symmetric V(1,1) cycle (docs/engine.md), one
// kernel per half-sweep over all cells of a colour (grid_flat_cycle.cl).
#pragma once

#include <vector>

#include "device/context.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"

namespace kappamu::forward {

class FlatCycle {
 public:
  /// Takes fields for the coarse levels at `lanes` patterns, the most any call will use, from the
  /// hierarchy's workspace.
  FlatCycle(device::Context& context, const Format& format, const Hierarchy& hierarchy, int lanes);

  /// z = M r on red cells of the finest level, and partial sums of r·z (LaneKernels::partials).
  /// `scratch` holds red cells; black ones of z are scratch. All have kernels.lanes() lanes.
  void precondition(const LaneKernels& kernels, const device::Buffer& r, const device::Buffer& z,
                    const device::Buffer& scratch, const device::Buffer& partial) const;

 private:
  struct Fields {
    device::Buffer rhs, solution, residual;
  };
  /// From level l's right-hand side to the coarser one's.
  void down(const LaneKernels& kernels, std::size_t l, const Fields& at,
            const device::Buffer& coarse) const;
  /// From the coarser level's solution to level l's.
  void up(const LaneKernels& kernels, std::size_t l, const Fields& at,
          const device::Buffer& coarse) const;

  device::Context& context_;
  const Hierarchy& hierarchy_;
  std::vector<Fields> coarse_;  ///< of levels 1, 2, ...
};

}  // namespace kappamu::forward
