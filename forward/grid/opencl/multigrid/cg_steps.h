// One step of preconditioned conjugate gradients on a batch, in two ways of using a device.
// Flat steps go kernel by kernel over the whole grid (GPUs: very many items), stream steps take a
// few sweeps that keep intermediate planes in the cache (CPUs). The algorithm is the same: unknowns
// are red cells, black ones being eliminated, and the V-cycle smooths by damped Jacobi on that
// reduced system (docs/engine.md).
#pragma once

#include <memory>
#include <vector>

#include "device/context.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"

namespace kappamu::forward {

using LaneScalars = std::vector<double>;  ///< [lane]

/// What a solve starts from; that x is zero need not be read.
enum class InitialGuess { zero, given };

/// The solution of A φ = b is sought as x + d: x where the caller keeps it, and a correction d in
/// here, along with the residual and the direction. Each call: kernels.lanes() lanes.
class CgSteps {
 public:
  virtual ~CgSteps() = default;

  /// d = 0, and the next step has no direction before it.
  virtual void begin(InitialGuess guess) = 0;

  /// Rounds x + d to x, leaving the rest, far smaller, to d, and replaces the residual by the true
  /// one, b − A (x + d) with arithmetic in double; x is then a solution as good as that residual.
  /// Returns its ‖·‖² for each lane, and ‖b‖².
  struct Norms {
    LaneScalars rr, bb;
  };
  virtual Norms true_residual(const LaneKernels& kernels, const device::Buffer& b,
                              const device::Buffer& x) = 0;

  /// d += α p and r −= α A p along the next direction p. Returns ‖r‖² of each lane.
  virtual LaneScalars step(const LaneKernels& kernels) = 0;

  /// Forgets the direction: the next step begins with the preconditioned residual.
  virtual void restart() = 0;
};

/// Vectors for at most `lanes` patterns at once, in the hierarchy's workspace.
std::unique_ptr<CgSteps> make_flat_steps(device::Context& context, const Format& format,
                                         const Hierarchy& hierarchy, int lanes);
std::unique_ptr<CgSteps> make_stream_steps(device::Context& context, const Format& format,
                                           const Hierarchy& hierarchy, int lanes);

/// Sums of kernels that leave one number per lane and row or work-group: fixed order, equal bits.
class LaneSums {
 public:
  LaneSums(device::Context& context, const Format& format);

  /// Σ over `count` vectors of `partial`, on the device.
  void add_up(const LaneKernels& kernels, const device::Buffer& partial, std::size_t count,
              const device::Buffer& sum);
  /// `count` values per lane, [count][lane].
  LaneScalars read(const LaneKernels& kernels, const device::Buffer& values, std::size_t count = 1);

 private:
  device::Context& context_;
  Format format_;
};

}  // namespace kappamu::forward
