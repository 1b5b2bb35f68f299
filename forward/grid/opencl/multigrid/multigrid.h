// The preconditioner of flat steps: the stream steps' symmetric V(1,1) cycle (docs/engine.md) on
// vectors of all cells, kernel by kernel: black, red, black before and after the coarse correction,
// black cells solved, red ones relaxed by damped Jacobi on the reduced system. The residual lives
// on red cells only, and black ones need no correction: both transfers touch half the cells.
#pragma once

#include <vector>

#include "device/context.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"

namespace kappamu::forward {

class Multigrid {
 public:
  /// Work space for the coarse levels at `lanes` patterns, the most any call will use.
  Multigrid(device::Context& context, const Format& format, const Hierarchy& hierarchy, int lanes);

  /// z = M r on the finest level; `scratch` is overwritten. All have kernels.lanes() lanes.
  void precondition(const LaneKernels& kernels, const device::Buffer& r, const device::Buffer& z,
                    const device::Buffer& scratch) const;

 private:
  struct Fields {
    device::Buffer rhs, solution, residual;
  };
  void cycle(const LaneKernels& kernels, std::size_t l, const Fields& at) const;
  void smooth(const LaneKernels& kernels, const char* kernel, const Level& level,
              const device::Buffer& smoother, int colour, const Fields& at) const;
  void transfer(const LaneKernels& kernels, const char* kernel, const Level& fine,
                const GridShape& coarse, const GridShape& items, const device::Buffer& from,
                const device::Buffer& to) const;

  device::Context& context_;
  const Hierarchy& hierarchy_;
  std::vector<Fields> coarse_;  ///< of levels 1, 2, ...
};

}  // namespace kappamu::forward
