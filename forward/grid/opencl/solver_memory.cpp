#include "forward/grid/opencl/solver_memory.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/process_memory.h"
#include "core/shown_text.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"
#include "forward/grid/opencl/opencl_field.h"
#include "forward/grid/opencl/opencl_solver.h"

namespace kappamu::forward {

namespace {

/// Of the device's memory: the rest is the driver's, the display's or, on a CPU, everybody's.
constexpr double usable_share = 0.85;
/// Rings and partial sums: small beside the fields of any grid that could fail to fit.
constexpr double slack = 1.03;
constexpr std::size_t slack_bytes = std::size_t{48} << 20;

std::size_t lanes_in_blocks(int patterns, int lanes) {
  std::size_t total = 0;
  for (const Block& block : cut_into_blocks(patterns, lanes)) {
    total += static_cast<std::size_t>(block.lanes);
  }
  return total;
}

/// The next level at worst: halved along one axis only.
GridShape largest_below(const GridShape& shape) {
  GridShape largest{1, 1, 1, shape.voxel_mm};
  for (std::size_t a = 0; a < 3; ++a) {
    std::array<int, 3> halving{0, 0, 0};
    halving[a] = 1;
    const GridShape below = coarser_grid(shape, halving);
    if (below.cells() < shape.cells() && below.cells() > largest.cells()) largest = below;
  }
  return largest;
}

}  // namespace

std::size_t solver_memory(const GridSetup& setup, int patterns, int fields, int lanes,
                          const Format& format, Layout layout) {
  const std::size_t cells = setup.shape.cells();
  const auto width = static_cast<std::size_t>(lanes);
  // Scalars per cell: κ, μ and first collisions; on every level stencils and weights, on GPUs the
  // smoother too. Of the set-up: of two levels three faces and the sink; of the finest what it
  // inverts, how loosely nodes are held and a weight. Vectors: r, d, z, p and one more, kernel by
  // kernel with room for black cells in all but r; per coarse level two, or two and a half kernel
  // by kernel, but on processors those of level 1 and all right-hand sides are borrowed of the
  // former.
  const bool sweeps = layout == Layout::cpu;
  const std::size_t reds = half_cells(setup.shape);
  std::size_t scalars = 3 * cells, set_up = 3 * cells, vectors = 0, level_1 = 0, below = 0;
  int l = 0;
  for (GridShape s = setup.shape;; s = largest_below(s), ++l) {
    scalars += (2 * stencil_reals + weight_reals) * half_cells(s) + (sweeps ? 0 : s.cells());
    if (l < 2) set_up += s.cells();
    for (int axis = 0; l < 2 && axis < 3; ++axis) set_up += face_count(s, axis);
    if (!sweeps && l > 0) vectors += 5 * half_cells(s);
    if (sweeps && (l == 2 || l == 3)) vectors += s.cells();
    if (l == 1) level_1 = s.cells();
    if (l > 1) below += s.cells();
    if (s.cells() == 1) break;
  }
  vectors +=
      sweeps ? 2 * reds + std::max(reds, level_1) + 2 * std::max({reds, level_1, below}) : 9 * reds;
  // Set-up and vectors take the same places in turn (Workspace), which are not filled to the brim;
  // but of one pattern in sweeps each vector fits the place of an array.
  const std::size_t unfilled = sweeps && lanes == 1 ? 0 : 3 * cells;
  const std::size_t workspace = std::max(set_up, vectors * width) + unfilled;
  const std::size_t batches =
      static_cast<std::size_t>(fields) * cells * lanes_in_blocks(patterns, lanes);
  const std::size_t reals = scalars + workspace + batches;
  return static_cast<std::size_t>(slack * static_cast<double>(reals * format.real_bytes())) +
         slack_bytes;
}

std::size_t solver_memory(const GridSetup& setup, int patterns, int fields, int at_once,
                          Precision precision) {
  const Format format{precision == Precision::single_precision, true};
  return solver_memory(setup, patterns, fields, cut_into_blocks(at_once, full_lanes).front().lanes,
                       format, Layout::cpu);
}

int lanes_that_fit(const GridSetup& setup, const device::DeviceInfo& device, const Format& format,
                   Layout layout) {
  const double usable = usable_share * static_cast<double>(device.global_memory_bytes);
  for (const int lanes : {full_lanes, 8, 4, 1}) {
    const std::size_t field =
        setup.shape.cells() * static_cast<std::size_t>(lanes) * format.real_bytes();
    const auto needed = static_cast<double>(solver_memory(setup, lanes, 3, lanes, format, layout));
    if (needed <= usable && field <= device.max_allocation_bytes) return lanes;
  }
  const GridShape& s = setup.shape;
  throw InputError(
      formatted("grid of %d x %d x %d voxels needs ", s.nx, s.ny, s.nz) +
          gigabytes(static_cast<double>(solver_memory(setup, 1, 3, 1, format, layout))) +
          " even one pattern at a time, device '" + device.name + "' has " +
          gigabytes(static_cast<double>(device.global_memory_bytes)) + ", " +
          gigabytes(static_cast<double>(device.max_allocation_bytes)) +
          " at most in one piece; use a coarser grid or another device",
      {{"device"}});
}

}  // namespace kappamu::forward
