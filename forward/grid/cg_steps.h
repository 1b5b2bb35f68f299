// One step of preconditioned conjugate gradients on a batch, in two ways of using a device: kernel
// by kernel over the whole grid (GPUs: very many items), or in a few sweeps that keep intermediate
// planes in the cache (CPUs). The arithmetic is the same, its rounding is not.
#pragma once

#include <memory>
#include <vector>

#include "device/context.h"
#include "forward/grid/grid_hierarchy.h"
#include "forward/grid/grid_kernels.h"

namespace kappamu::forward {

using LaneScalars = std::vector<double>;  ///< [lane]

class CgSteps {
 public:
  virtual ~CgSteps() = default;

  /// Forgets the direction: the next step begins with the preconditioned residual.
  virtual void restart() = 0;

  /// x += α p and r −= α A p along the next direction p; with first_x, x is taken for zero whatever
  /// it holds. Returns ‖r‖² of each lane.
  virtual LaneScalars step(const LaneKernels& kernels, const device::Buffer& r,
                           const device::Buffer& x, bool first_x) = 0;
};

/// Work space for at most `lanes` patterns at once.
std::unique_ptr<CgSteps> make_flat_steps(device::Context& context, const Format& format,
                                         const Hierarchy& hierarchy, int lanes);
std::unique_ptr<CgSteps> make_stream_steps(device::Context& context, const Format& format,
                                           const Hierarchy& hierarchy, int lanes);

/// Sums of kernels that leave one number per lane and row or run: fixed order, equal bits.
class LaneSums {
 public:
  LaneSums(device::Context& context, const Format& format, int lanes);

  /// Σ over `count` vectors of `partial`, on the device.
  void add_up(const LaneKernels& kernels, const device::Buffer& partial, std::size_t count,
              const device::Buffer& sum);
  /// `count` values per lane, [count][lane].
  LaneScalars read(const LaneKernels& kernels, const device::Buffer& values, std::size_t count = 1);

 private:
  device::Context& context_;
  Format format_;
  device::Buffer stripes_;
};

}  // namespace kappamu::forward
