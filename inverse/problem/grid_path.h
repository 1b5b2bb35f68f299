// The path of a fit over the grids, coarse to fine: the grid that is fitted, its objective with the
// correction r, and what goes on to the next.
#pragma once

#include <memory>
#include <optional>

#include "inverse/problem/grid_levels.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// Solves as loose as data of these relative deviations allow, the usual one and that which one
/// datum in twenty has at most; nothing changes without Backend::loose_solves.
Backend as_loose_as_data(Backend backend, double usual_deviation, double least_deviation);
/// Of the objective's derivatives.
double derivative_tolerance(const Backend& backend);
/// The relative deviations of a problem's data.
std::vector<double> relative_deviations(const Problem& problem);

enum class GridCorrection {
  none,
  next_finer  ///< r by the next finer grid, of the finest by its own with every voxel split
};

class GridPath {
 public:
  /// Nothing is open before open().
  GridPath(GridLevels levels, const Backend& backend, const DataTermOptions& data_term,
           GridCorrection correction);

  const GridLevels& levels() const { return levels_; }
  void set_photons(const std::optional<PhotonOptions>& photons) { levels_.set_photons(photons); }

  /// An objective of the grid `level`, or of GridLevels::closer(), whose solves are as loose as its
  /// data allow; no solve is counted yet and r is 1.
  void open(int level, bool closer = false);

  int level() const { return level_; }  ///< of levels(), 0 = finest
  bool closer() const { return closer_; }
  Objective& objective() { return *objective_; }
  const Objective& objective() const { return *objective_; }
  const Problem& problem() const { return objective_->problem(); }
  const MediumSpace& space() const { return objective_->space(); }
  const GridShape& shape() const { return space().shape; }

  /// What r is made by on this grid.
  Refinement refinement() const { return levels_.refinement(level_); }
  /// r anew at `fields`, by photons as scarce as PhotonOptions::noise makes them; χ² per value with
  /// it.
  double renew_correction(const CoefficientPair& fields, double photon_noise = 1.0);

  /// From level 1 to GridLevels::closer() there: r and the count of solves stay. False where that
  /// is not next.
  bool go_closer();

  /// Opens the next finer grid, where the count of solves goes on; `fields` there.
  CoefficientPair refine(const CoefficientPair& fields);

 private:
  GridLevels levels_;
  Backend backend_;
  DataTermOptions data_term_;
  GridCorrection correction_;
  int level_ = 0;
  bool closer_ = false;
  std::unique_ptr<Objective> objective_;
};

}  // namespace kappamu::inverse
