// The grid solvers behind the common interface of forward models.
#pragma once

#include <memory>

#include "forward/forward_model.h"

namespace kappamu::forward {

/// Multigrid-preconditioned conjugate gradients on the device the options name.
std::unique_ptr<ForwardModel> make_multigrid_model();

/// The serial double reference, whatever device the options name.
std::unique_ptr<ForwardModel> make_reference_model();

}  // namespace kappamu::forward
