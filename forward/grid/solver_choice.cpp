// Which backend solves: the one place that knows them all.
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

SolverChoice make_grid_solver(const GridSetup& setup, const std::string& device,
                              Precision /*precision*/) {
  if (device == "reference") return {make_reference_solver(setup), ""};
  return {make_reference_solver(setup),
          "The OpenCL grid solver is not part of this build: solving with the serial reference."};
}

}  // namespace kappamu::forward
