// The grids of a coarse-to-fine fit: the data's own is level 0, each next one has voxels of twice
// the edge.
#pragma once

#include <optional>
#include <vector>

#include "inverse/problem/objective.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

enum class DataWeights {
  by_variance,  ///< 1/σ² of each datum
  equal         ///< equalise_weights() on every grid
};

class GridLevels {
 public:
  /// At most `most` grids, at least one. Coarser ones keep four voxels along every axis and data
  /// enough to fit; `coarse_model_error` is theirs.
  GridLevels(Problem finest, const ModelError& coarse_model_error, DataWeights weights, int most);

  int count() const { return static_cast<int>(problems_.size()); }
  int coarsest() const { return count() - 1; }
  const Problem& operator[](int level) const { return problems_[static_cast<std::size_t>(level)]; }
  /// Level 1 with a third of its model error, on which data whose pixels share errors are fitted
  /// once more before the finest grid; null where there are other data, fewer than three grids or
  /// no such error.
  const Problem* closer() const { return closer_ ? &*closer_ : nullptr; }

  /// r of every level by photons too, or not.
  void set_photons(const std::optional<PhotonOptions>& photons) { photons_ = photons; }
  const std::optional<PhotonOptions>& photons() const { return photons_; }

  /// The next finer grid; of level 0 its own with every voxel split.
  Refinement refinement(int level) const;
  /// `fields` of a level above 0 on the next finer grid.
  CoefficientPair to_finer(const CoefficientPair& fields, int level) const;

 private:
  std::vector<Problem> problems_;
  std::optional<Problem> closer_;
  std::optional<PhotonOptions> photons_;
};

}  // namespace kappamu::inverse
