#include "forward/grid/opencl/kernels/grid_kernels.h"

#include <algorithm>
#include <string>

#include "core/error.h"

namespace kappamu::forward {

extern const device::KernelSource grid_flat_cl, grid_flat_residual_cl, grid_lanes_cl,
    grid_levels_cl, grid_stream_cl, grid_stream_residual_cl;

namespace {

std::string number_options(const Format& format) {
  return std::string(format.single ? "-DREAL=float" : "-DREAL=double") +
         (format.accurate_sums ? " -DACCU=double" : " -DACCU=float");
}

std::string segment_option(Layout layout) {
  return layout == Layout::gpu ? " -DSEGMENT=1" : "";
}

}  // namespace

Format format_of(const device::DeviceInfo& device, Precision precision) {
  if (precision == Precision::double_precision && !device.fp64) {
    throw InputError("device '" + device.name +
                         "' has no double precision; use single precision or another device",
                     {{"precision", "single"}, {"device"}});
  }
  return {precision == Precision::single_precision, device.fp64};
}

device::Program& level_program(device::Context& context, const Format& format, Layout layout) {
  return context.program(grid_levels_cl, number_options(format) + segment_option(layout));
}

Layout layout_of(const device::DeviceInfo& device) {
  return device.kind == device::Kind::gpu ? Layout::gpu : Layout::cpu;
}

LaneKernels::LaneKernels(device::Context& context, const Format& format, Layout layout, int lanes)
    : lanes_(lanes), layout_(layout) {
  const bool gpu = layout == Layout::gpu;
  const int width = gpu ? std::min(lanes, 4) : lanes;
  groups_ = lanes / width;
  const std::string options = number_options(format) + " -DWIDTH=" + std::to_string(width) +
                              " -DGROUPS=" + std::to_string(groups_) + segment_option(layout);
  common_ = &context.program(grid_lanes_cl, options);
  steps_ = &context.program(gpu ? grid_flat_cl : grid_stream_cl, options);
  residual_ = &context.program(gpu ? grid_flat_residual_cl : grid_stream_residual_cl, options);
}

namespace {
std::size_t row_count(const GridShape& grid) {
  return static_cast<std::size_t>(grid.ny) * static_cast<std::size_t>(grid.nz);
}
}  // namespace

device::Range LaneKernels::rows(const GridShape& grid) const {
  const auto groups = static_cast<std::size_t>(groups_);
  if (layout_ == Layout::cpu) return {groups, row_count(grid), 1, 1};
  return {groups * static_cast<std::size_t>(grid.nx), row_count(grid), 64, 1};
}

device::Range scalar_rows(Layout layout, const GridShape& grid) {
  if (layout == Layout::cpu) return {1, row_count(grid), 1, 1};
  return {static_cast<std::size_t>(grid.nx), row_count(grid), 64, 1};
}

device::Range LaneKernels::items(std::size_t count) const {
  const auto groups = static_cast<std::size_t>(groups_);
  if (layout_ == Layout::cpu) return {groups, count, 1, 1};
  return {groups, count, groups, 64 / groups};
}

device::Range LaneKernels::flat(std::size_t count) const {
  return {static_cast<std::size_t>(groups_) * count, 1, workgroup, 1};
}

namespace {
std::size_t slots(int nx, int ny, int nz) {
  const auto tiles = [](int n, int size) { return static_cast<std::size_t>((n - 1) / size + 1); };
  return 64 * tiles(nx, 8) * tiles(ny, 4) * tiles(nz, 2);
}
}  // namespace

device::Range LaneKernels::tiled(const GridShape& grid) const {
  return flat(slots((grid.nx + 1) / 2, grid.ny, grid.nz));
}

device::Range LaneKernels::tiled_cells(const GridShape& grid) const {
  return flat(slots(grid.nx, grid.ny, grid.nz));
}

device::Range LaneKernels::summed(const GridShape& grid) const {
  device::Range range = tiled(grid);
  range.global0 = std::min(range.global0, workgroup * most_partials);
  return range;
}

std::size_t LaneKernels::partials(const GridShape& grid) const {
  return (summed(grid).global0 - 1) / workgroup + 1;
}

}  // namespace kappamu::forward
