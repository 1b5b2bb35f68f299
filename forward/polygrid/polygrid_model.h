// Model `polygrid` of objects ([W] 5): diffusion on the deformed cells of a polycube, of as many as
// the tolerance needs.
#pragma once

#include <functional>

#include "forward/polygrid/polygrid.h"
#include "forward/registry.h"

namespace kappamu::forward {

class PolygridModel : public ChannelsModel {
 public:
  /// Of the first polygrid; the answer comes from eight times as many, or more. Objects whose
  /// topology these do not hold begin with more.
  static constexpr int first_cells = 6000;

  void describe(const OptionVisitor& visit) override;
  std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                           const ObjectOptions& options,
                                           Progress& progress) override;
  /// The polygrid, its equations and the last fluence.
  std::unique_ptr<LiveModel> keep(const LiveBody& object, const ObjectOptions& options,
                                  Progress& progress) override;

 private:
  int first_cells_ = first_cells;
};

/// The first that `made` gives, by numbers of cells from `cells` on: handles and parts thinner than
/// its cells may need more. Throws what the last threw.
Polygrid first_polygrid(int cells, const std::function<Polygrid(int cells)>& made);

ModelDescription polygrid_model();

}  // namespace kappamu::forward
