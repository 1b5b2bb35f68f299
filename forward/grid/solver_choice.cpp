// Which backend solves: the one place that knows them all.
#include <utility>

#include "device/device_info.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/opencl_solver.h"
#include "forward/grid/solver_self_test.h"

namespace kappamu::forward {

SolverChoice trusted_or_reference(std::unique_ptr<GridSolver> solver, const GridSetup& setup,
                                  const std::string& device_name, const Verdict& verdict) {
  if (verdict.trusted) return {std::move(solver), ""};
  return {make_reference_solver(setup),
          "device '" + device_name + "' fails its known-answer test (" + verdict.message +
              "): its results are not to be trusted, so the slow serial reference solves instead"};
}

SolverChoice make_grid_solver(const GridSetup& setup, const std::string& device,
                              Precision precision) {
  if (device == "reference") return {make_reference_solver(setup), ""};
  const auto devices = device::list_devices();
  const std::size_t index = device::choose(devices, device).index;
  try {
    device::Context& context = device::Context::of(index);
    // Bad input must not read as a bad device: the solver refuses it before the test is made.
    auto solver = make_opencl_solver(setup, context, {.precision = precision});
    return trusted_or_reference(std::move(solver), setup, devices[index].name,
                                device_verdict(context, precision));
  } catch (const device::DeviceError& error) {
    return trusted_or_reference(nullptr, setup, devices[index].name, {false, error.what()});
  }
}

}  // namespace kappamu::forward
