// Answers on polygrids of as many cells as the tolerance needs.
#pragma once

#include <functional>
#include <optional>

#include "forward/object_model.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward {

/// A polygrid of the problems' mesh of about as many cells; none: such a number gives none.
using PolygridMaker = std::function<std::optional<Polygrid>(int cells)>;

/// One result per channel, as ObjectModel::solve_channels() gives them. `first` is of the problems'
/// own mesh. Each answer is taken on a polygrid and on the same with its cells split in eight.
/// Where these two differ by more than the tolerance, the error and the order at which it fell give
/// the number of cells of the next, which `maker` makes: it reaches parts that the one before left
/// out, as a split does not. Without a maker, or where it gives none, the finer grid is split.
/// Throws InputError where the memory bound or max_elements allow no second resolution.
std::vector<ObjectResult> solve_on_polygrid(Polygrid first, std::span<const ObjectProblem> problems,
                                            const ObjectOptions& options, Progress& progress,
                                            const PolygridMaker& maker = {});

/// Cells that one of `cells` and error `error` needs for `tolerance`, where the error falls with
/// the edge to the power `order`.
double polygrid_cells_needed(double cells, double error, double tolerance, double order);

/// The order at which the error fell from one number of cells to another, within [0.5, 2].
double polygrid_order(double cells_before, double error_before, double cells, double error);

/// Each light's relative error of the exitance on the finer of two resolutions, one half the
/// other, in the surface's 2-norm; `coarse` and `fine` are [light][triangle]. `gaps` as SurfaceMap
/// has them, none: not counted. On a triangle that lies a gap g off the polygrid, fluence falls to
/// zero within the extrapolation length 2Aκ: the exitance there is taken to be wrong by the share
/// min(1, g/(2Aκ)).
std::vector<double> polygrid_errors(const ObjectProblem& problem, std::span<const double> gaps,
                                    std::span<const double> coarse, std::span<const double> fine);

}  // namespace kappamu::forward
