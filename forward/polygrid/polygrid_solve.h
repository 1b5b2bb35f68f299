// Answers on a polygrid that is split in eight until two resolutions agree within the tolerance.
#pragma once

#include "forward/object_model.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward {

/// One result per channel, as ObjectModel::solve_channels() gives them; `grid` is of the problems'
/// own mesh. Throws InputError where max_elements or memory allow no second resolution.
std::vector<ObjectResult> solve_on_polygrid(Polygrid grid, std::span<const ObjectProblem> problems,
                                            const ObjectOptions& options, Progress& progress);

/// Each light's relative error of the exitance on the finer of two resolutions, one half the
/// other, in the surface's 2-norm; `coarse` and `fine` are [light][triangle].
std::vector<double> polygrid_errors(const ObjectProblem& problem, std::span<const double> coarse,
                                    std::span<const double> fine);

}  // namespace kappamu::forward
