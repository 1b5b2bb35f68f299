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

/// Items for the rows of a grid, for all patterns together (FOR_SCALAR_ROW in grid_prelude.cl).
device::Range scalar_rows(Layout layout, const GridShape& grid);

/// Conductances of a level, the next coarser one's from them, and first collisions of a beam: no
/// lanes.
device::Program& level_program(device::Context& context, const Format& format, Layout layout);

/// Everything that works on a batch of `lanes` patterns.
class LaneKernels {
 public:
  LaneKernels(device::Context& context, const Format& format, Layout layout, int lanes);

  int lanes() const { return lanes_; }
  Layout layout() const { return layout_; }
  /// The operator, surfaces and sums.
  device::Program& common() const { return *common_; }
  /// Of this layout: grid_stream_*.cl and grid_reduced.cl, or grid_flat_*.cl.
  device::Program& steps() const { return *steps_; }
  device::Program& residual() const { return *residual_; }

  /// Items for the rows of a grid (FOR_ROW and FOR_SCALAR_ROW in grid_prelude.cl).
  device::Range rows(const GridShape& grid) const;
  device::Range scalar_rows(const GridShape& grid) const {
    return forward::scalar_rows(layout_, grid);
  }
  /// Items for `count` pieces of work per vector group.
  device::Range items(std::size_t count) const;
  /// Layout::gpu: items for `count` pieces of work per vector group, neighbours beside each other.
  device::Range flat(std::size_t count) const;
  /// Items for one colour of a grid, or all of its cells, in tiles (grid_flat_prelude.cl); or
  /// fewer, for a kernel that leaves `partials` sums, one per work-group.
  device::Range tiled(const GridShape& grid) const;
  device::Range tiled_cells(const GridShape& grid) const;
  device::Range summed(const GridShape& grid) const;
  std::size_t partials(const GridShape& grid) const;
  static constexpr std::size_t workgroup = 256;       ///< WORKGROUP in grid_flat_prelude.cl
  static constexpr std::size_t most_partials = 1024;  ///< fills the largest GPU

 private:
  int lanes_, groups_;
  Layout layout_;
  device::Program *common_, *steps_, *residual_;
};

}  // namespace kappamu::forward
