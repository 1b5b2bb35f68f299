// Which backend solves: the one place that knows them all.
#include "device/device_info.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl_solver.h"

namespace kappamu::forward {

SolverChoice make_grid_solver(const GridSetup& setup, const std::string& device,
                              Precision precision) {
  if (device == "reference") return {make_reference_solver(setup), ""};
  const auto choice = device::choose(device::list_devices(), device);
  return {make_opencl_solver(setup, device::Context::of(choice.index), precision), ""};
}

}  // namespace kappamu::forward
