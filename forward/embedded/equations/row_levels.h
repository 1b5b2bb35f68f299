// The levels of a cut mesh as row matrices, for the linear solver.
#pragma once

#include "forward/embedded/equations/levels.h"
#include "forward/linear/row_solver.h"

namespace kappamu::forward::embedded {

/// Those of the media of `lanes`. The two finest can be solved on.
linear::RowLevels make_row_levels(const Levels& levels, const linear::Lanes& lanes);
/// The same for a solver. Keeps a reference.
inline linear::Assembly row_levels_of(const Levels& levels) {
  return [&levels](const linear::Lanes& lanes) { return make_row_levels(levels, lanes); };
}

}  // namespace kappamu::forward::embedded
