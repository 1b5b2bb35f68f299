#include "forward/polygrid/linear_solver.h"

#include "device/context.h"
#include "forward/polygrid/opencl/opencl_solver.h"

namespace kappamu::forward::polygrid {

std::unique_ptr<LinearSolver> make_linear_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 const std::string& device, Lights lights) {
  if (device == "reference" || (device == "auto" && device::list_devices().empty())) {
    return make_host_solver(equations, hierarchy);
  }
  return make_opencl_solver(equations, hierarchy, device::Context::chosen(device),
                            Precision::single, lights);
}

}  // namespace kappamu::forward::polygrid
