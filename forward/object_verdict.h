// How an answer refined over one or several bodies states its error and how it ended.
#pragma once

#include "forward/object_model.h"

namespace kappamu::forward {

/// Whether every body met the tolerance, and its linear systems theirs.
struct Ended {
  bool within_tolerance = true, solved = true;
};

/// Turns `error_estimate`, the sums over bodies of squared 2-norms, into relative errors and fills
/// `converged`, `message` and its warning. `elements` names what the model refines ("cubes").
void conclude(const Surface& surface, const Ended& ended, const std::string& elements,
              ObjectResult& result);

}  // namespace kappamu::forward
