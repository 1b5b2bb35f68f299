#include "forward/grid/solver_memory.h"

#include <algorithm>
#include <array>
#include <iomanip>
#include <sstream>

#include "core/error.h"
#include "forward/grid/grid_hierarchy.h"
#include "forward/grid/opencl_field.h"
#include "forward/grid/opencl_solver.h"

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

std::string gigabytes(double bytes) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << bytes / 1e9 << " GB";
  return text.str();
}

}  // namespace

std::size_t solver_memory(const GridSetup& setup, int patterns, int fields, int lanes,
                          const Format& format, Layout layout) {
  const std::size_t cells = setup.shape.cells();
  const auto width = static_cast<std::size_t>(lanes);
  const std::size_t row_reds = (static_cast<std::size_t>(setup.shape.nx) + 1) / 2;
  const std::size_t reds = cells / static_cast<std::size_t>(setup.shape.nx) * row_reds;
  // Scalars per cell: κ, μ and first collisions; on every level three faces, sink, two diagonals
  // and three weights. Vectors: r, d, z, p and one more; per coarse level two, or three kernel by
  // kernel, but on processors level 1 borrows some of the former.
  const bool borrows = layout == Layout::cpu;
  std::size_t scalars = 3 * cells;
  std::size_t vectors =
      borrows ? 2 * reds + 3 * std::max(reds, largest_below(setup.shape).cells()) : 5 * cells;
  int l = 0;
  for (GridShape s = setup.shape;; s = largest_below(s), ++l) {
    for (int axis = 0; axis < 3; ++axis) scalars += face_count(s, axis);
    scalars += 6 * s.cells();
    if (l >= (borrows ? 2 : 1)) vectors += (borrows ? 2 : 3) * s.cells();
    if (s.cells() == 1) break;
  }
  const std::size_t batches =
      static_cast<std::size_t>(fields) * cells * lanes_in_blocks(patterns, lanes);
  const std::size_t reals = scalars + vectors * width + batches;
  return static_cast<std::size_t>(slack * static_cast<double>(reals * format.real_bytes())) +
         slack_bytes;
}

std::size_t solver_memory(const GridSetup& setup, int patterns, Precision precision) {
  const Format format{precision == Precision::single_precision, true};
  return solver_memory(setup, patterns, 2, cut_into_blocks(patterns, full_lanes).front().lanes,
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
  std::ostringstream message;
  message << "grid of " << setup.shape.nx << " x " << setup.shape.ny << " x " << setup.shape.nz
          << " voxels needs "
          << gigabytes(static_cast<double>(solver_memory(setup, 1, 3, 1, format, layout)))
          << " even one pattern at a time, device '" << device.name << "' has "
          << gigabytes(static_cast<double>(device.global_memory_bytes)) << ", "
          << gigabytes(static_cast<double>(device.max_allocation_bytes))
          << " at most in one piece; use a coarser grid or another --device";
  throw InputError(message.str());
}

}  // namespace kappamu::forward
