// What to tell a user whose solve ended at the rounding of its own storage.
#pragma once

#include <string>

#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Half a sentence, to follow "tolerance ... not met: ": names the floor, and what goes below it
/// where something does.
std::string rounding_floor_sentence(Precision precision);

}  // namespace kappamu::forward
