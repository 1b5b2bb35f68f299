// The same equations without rows, levels or single precision: cube by cube, conjugate gradients
// with the diagonal, one thread. What the solver is compared with.
#pragma once

#include "forward/embedded/equations/cube_elements.h"
#include "forward/embedded/equations/node_space.h"

namespace kappamu::forward::embedded {

/// A x, summed cube by cube.
std::vector<double> reference_product(const NodeSpace& space, const Elements& elements,
                                      std::size_t channel, const std::vector<double>& x);
/// Solves A x = b to ‖b − A x‖ ≤ tolerance·‖b‖; throws InternalError where 10,000 iterations do
/// not.
std::vector<double> reference_solution(const NodeSpace& space, const Elements& elements,
                                       std::size_t channel, const std::vector<double>& b,
                                       double tolerance);

}  // namespace kappamu::forward::embedded
