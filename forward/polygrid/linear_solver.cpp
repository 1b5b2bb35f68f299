#include "forward/polygrid/linear_solver.h"

#include "device/context.h"
#include "forward/polygrid/opencl/opencl_solver.h"

namespace kappamu::forward::polygrid {

std::unique_ptr<LinearSolver> make_linear_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 const std::string& device, Lights lights) {
  const auto devices = device::list_devices();
  if (device == "reference" || (device == "auto" && devices.empty())) {
    return make_host_solver(equations, hierarchy);
  }
  return make_opencl_solver(equations, hierarchy,
                            device::Context::of(device::choose(devices, device).index),
                            Precision::single, lights);
}

}  // namespace kappamu::forward::polygrid
