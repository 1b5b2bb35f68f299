#include "forward/embedded/solver_choice.h"

#include "device/context.h"
#include "forward/embedded/equations/row_levels.h"

namespace kappamu::forward::embedded {

namespace {

/// Fewer unknowns are solved for before a device has its kernels.
constexpr std::size_t few_unknowns = 30'000;

/// Whether the host's threads are the faster.
bool host_is_faster(const Levels& levels, std::size_t lights) {
  const auto devices = device::list_devices();
  if (devices.empty() || levels.unknowns() < few_unknowns) return true;
  const device::DeviceInfo& info = devices[device::choose(devices, "auto").index];
  return !info.fp64 || (info.kind != device::Kind::gpu && lights == 1);
}

}  // namespace

std::unique_ptr<LinearSolver> make_linear_solver(const Levels& levels, std::size_t lights,
                                                 const std::string& device) {
  if (device == "reference" || (device == "auto" && host_is_faster(levels, lights))) {
    return linear::make_host_solver(row_levels_of(levels));
  }
  return linear::make_opencl_solver(row_levels_of(levels), device::Context::chosen(device));
}

}  // namespace kappamu::forward::embedded
