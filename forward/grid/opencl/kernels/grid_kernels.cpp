#include "forward/grid/opencl/kernels/grid_kernels.h"

#include <algorithm>
#include <string>

#include "core/error.h"

namespace kappamu::forward {

extern const device::KernelSource grid_assemble_cl, grid_beam_cl, grid_coarsen_cl, grid_operator_cl,
    grid_reduced_cl, grid_stream_cycle_cl, grid_stream_step_cl, grid_surface_cl, grid_transfer_cl,
    grid_vectors_cl;

namespace {

std::string number_options(const Format& format) {
  return std::string(format.single ? "-DREAL=float" : "-DREAL=double") +
         (format.accurate_sums ? " -DACCU=double" : " -DACCU=float");
}

}  // namespace

Format format_of(const device::DeviceInfo& device, Precision precision) {
  if (precision == Precision::double_precision && !device.fp64) {
    throw InputError("device '" + device.name +
                     "' has no double precision; use --precision single or another --device");
  }
  return {precision == Precision::single_precision, device.fp64};
}

device::Program& assembly_program(device::Context& context, const Format& format) {
  return context.program(grid_assemble_cl, number_options(format));
}

device::Program& coarsening_program(device::Context& context, const Format& format) {
  return context.program(grid_coarsen_cl, number_options(format));
}

device::Program& beam_program(device::Context& context, const Format& format) {
  return context.program(grid_beam_cl, number_options(format));
}

Layout layout_of(const device::DeviceInfo& device) {
  return device.kind == device::Kind::gpu ? Layout::gpu : Layout::cpu;
}

namespace {
/// Cells of a row one item walks; a CPU's item takes the whole row.
int segment_of(Layout layout) {
  return layout == Layout::gpu ? 16 : 0x40000000;
}
std::size_t segments(const GridShape& grid, Layout layout) {
  return static_cast<std::size_t>((grid.nx - 1) / segment_of(layout) + 1);
}
}  // namespace

std::size_t row_sums(const GridShape& grid, Layout layout) {
  return grid.cells() / static_cast<std::size_t>(grid.nx) * segments(grid, layout);
}

int run_count(std::size_t cells, Layout layout) {
  // Enough runs to keep every core or lane busy, few enough to sum quickly afterwards.
  return static_cast<int>(std::min<std::size_t>(cells, layout == Layout::gpu ? 16384 : 256));
}

LaneKernels::LaneKernels(device::Context& context, const Format& format, Layout layout, int lanes)
    : lanes_(lanes), layout_(layout) {
  const bool gpu = layout == Layout::gpu;
  const int width = gpu ? std::min(lanes, 4) : lanes;
  groups_ = lanes / width;
  const std::string options = number_options(format) + " -DWIDTH=" + std::to_string(width) +
                              " -DGROUPS=" + std::to_string(groups_) +
                              " -DSEGMENT=" + std::to_string(segment_of(layout)) +
                              " -DINTERLEAVED=" + (gpu ? "1" : "0");
  operator_ = &context.program(grid_operator_cl, options);
  vectors_ = &context.program(grid_vectors_cl, options);
  surface_ = &context.program(grid_surface_cl, options);
  if (gpu) {
    transfer_ = &context.program(grid_transfer_cl, options);
  } else {
    reduced_ = &context.program(grid_reduced_cl, options);
    stream_cycle_ = &context.program(grid_stream_cycle_cl, options);
    stream_step_ = &context.program(grid_stream_step_cl, options);
  }
}

device::Range LaneKernels::rows(const GridShape& grid) const {
  device::Range range =
      items(static_cast<std::size_t>(grid.ny) * static_cast<std::size_t>(grid.nz));
  range.global0 = static_cast<std::size_t>(groups_) * segments(grid, layout_);
  return range;
}

device::Range LaneKernels::items(std::size_t count) const {
  const auto groups = static_cast<std::size_t>(groups_);
  if (layout_ == Layout::cpu) return {groups, count, 1, 1};
  return {groups, count, groups, 64 / groups};
}

}  // namespace kappamu::forward
