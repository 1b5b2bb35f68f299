// Model `grid` of objects: boxes along the axes by grid diffusion, on the medium's own voxels and
// finer ones until two resolutions agree within the tolerance.
#pragma once

#include "forward/registry.h"

namespace kappamu::forward {

/// Each light's relative error of the exitance on the finer of two grids, one twice the other, in
/// the surface's 2-norm; `coarse` and `fine` are [light][triangle].
std::vector<double> block_errors(const ObjectProblem& problem, std::span<const double> coarse,
                                 std::span<const double> fine);

class BlockModel : public ObjectModel {
 public:
  ObjectResult solve(const ObjectProblem& problem, const ObjectOptions& options,
                     Progress& progress) override;
  /// The grid, its equations and the last fluence.
  std::unique_ptr<LiveModel> keep(const LiveBody& object, const ObjectOptions& options,
                                  Progress& progress) override;
};

ModelDescription block_model();

}  // namespace kappamu::forward
