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
/// other, in the surface's 2-norm; `coarse` and `fine` are [light][triangle]. `gaps` as SurfaceMap
/// has them, none: not counted. On a triangle that lies a gap g off the polygrid, fluence falls to
/// zero within the extrapolation length 2Aκ: the exitance there is taken to be wrong by the share
/// min(1, g/(2Aκ)).
std::vector<double> polygrid_errors(const ObjectProblem& problem, std::span<const double> gaps,
                                    std::span<const double> coarse, std::span<const double> fine);

}  // namespace kappamu::forward
