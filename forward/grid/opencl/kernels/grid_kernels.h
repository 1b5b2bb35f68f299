// The OpenCL files of the grid solver, compiled for one precision and one number of lanes.
#pragma once

#include <cstddef>

#include "device/context.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// How numbers are stored and summed on a device.
struct Format {
  bool single = true;         ///< storage: float or double
  bool accurate_sums = true;  ///< sums in double, or in float where the device has no double
  std::size_t real_bytes() const { return single ? sizeof(float) : sizeof(double); }
  std::size_t accu_bytes() const { return accurate_sums ? sizeof(double) : sizeof(float); }
};

/// Throws InputError when double precision is asked of a device without it.
Format format_of(const device::DeviceInfo& device, Precision precision);

/// How work is cut into items. A CPU core wants all lanes of a cell in one vector and long rows; a
/// GPU wants many items whose neighbours touch neighbouring memory.
enum class Layout { cpu, gpu };
Layout layout_of(const device::DeviceInfo& device);

/// Rows of a grid times the segments they are cut into: how many sums its row kernels leave.
std::size_t row_sums(const GridShape& grid, Layout layout);
/// How many runs to cut `cells` into (grid_vectors.cl).
int run_count(std::size_t cells, Layout layout);

/// Conductances of a level, and the next coarser one's from them: no lanes.
device::Program& assembly_program(device::Context& context, const Format& format);
device::Program& coarsening_program(device::Context& context, const Format& format);
/// First collisions of a beam: no lanes.
device::Program& beam_program(device::Context& context, const Format& format);

/// Everything that works on a batch of `lanes` patterns.
class LaneKernels {
 public:
  LaneKernels(device::Context& context, const Format& format, Layout layout, int lanes);

  int lanes() const { return lanes_; }
  device::Program& level_operator() const { return *operator_; }
  device::Program& vectors() const { return *vectors_; }
  device::Program& surface() const { return *surface_; }
  /// Layout::gpu only: transfer(); Layout::cpu only: the three others.
  device::Program& transfer() const { return *transfer_; }
  device::Program& reduced() const { return *reduced_; }
  device::Program& stream_cycle() const { return *stream_cycle_; }
  device::Program& stream_step() const { return *stream_step_; }
  Layout layout() const { return layout_; }

  /// Items for the rows of a grid (grid_operator.cl, grid_transfer.cl).
  device::Range rows(const GridShape& grid) const;
  /// Items for `count` pieces of work per vector group.
  device::Range items(std::size_t count) const;
  int runs(std::size_t cells) const { return run_count(cells, layout_); }

 private:
  int lanes_, groups_;
  Layout layout_;
  device::Program* operator_;
  device::Program* transfer_ = nullptr;
  device::Program* vectors_;
  device::Program* surface_;
  device::Program* reduced_ = nullptr;
  device::Program* stream_cycle_ = nullptr;
  device::Program* stream_step_ = nullptr;
};

}  // namespace kappamu::forward
