// Solvers of a polygrid's equations for several lights and media (colour channels) at once.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "forward/embedded/equations/linear_solver.h"
#include "forward/polygrid/equations/hierarchy.h"

namespace kappamu::forward::polygrid {

using embedded::CgReport;
using embedded::Load;

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// One per channel; to be called before solve() and whenever a medium changes.
  virtual void set_media(const std::vector<MediumValues>& media) = 0;
  /// Solves A x = load for every light, by conjugate gradients from `x` [light][unknown] until
  /// ‖residual‖ ≤ tolerance·‖load‖. An `x` of another size starts at zero.
  virtual CgReport solve(const std::vector<Load>& loads, std::vector<std::vector<double>>& x,
                         double tolerance, int most_iterations) = 0;
};

/// Serial, in double precision, written to be read: the matrix by rows, conjugate gradients scaled
/// by its diagonal. Keeps a reference.
std::unique_ptr<LinearSolver> make_reference_solver(const Equations& equations);

/// "reference" is the serial one; other words name an OpenCL device as device::choose() takes them.
/// Without any OpenCL device "auto" is the serial one. Keeps references.
std::unique_ptr<LinearSolver> make_linear_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 const std::string& device);

}  // namespace kappamu::forward::polygrid
