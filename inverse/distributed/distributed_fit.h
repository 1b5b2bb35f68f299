// One channel of a block cut between ranks: from the best homogeneous block down the weights of the
// regulariser to the noise of the data (path_rules.h), each minimum found by PETSc's TAO.
//
// Of inverse/fit/fit.h it is the path alone, on the grid of the data, with H1: no coarser grids, no
// models of few unknowns, no correction of the grid's own error, no deviations.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "core/progress.h"
#include "inverse/distributed/piece_objective.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse::distributed {

/// Where a fit stands between two weights.
struct PathState {
  double weight = 0.0;      ///< that comes next
  double seconds = 0.0;     ///< so far
  FitReport report;         ///< so far: start and history
  std::vector<double> own;  ///< of this rank: log κ of its voxels, then log μ
};

/// Called by all ranks, with each one's part. load() gives nothing where there is no state of this
/// fit.
struct PathCheckpoint {
  std::function<void(const PathState&)> save;
  std::function<std::optional<PathState>()> load;
};

struct PieceFit {
  CoefficientPair fields;          ///< of the piece
  std::vector<double> prediction;  ///< exitance on the piece's seen face [M][v][u]; 0 off its own
  FitReport report;
};

/// Of `options` it takes the data's model error, the regulariser's anchor, the path and the
/// solver's tolerances. Throws InputError.
PieceFit fit_pieces(std::shared_ptr<const BlockPieces> pieces, const Problem& problem,
                    const FitOptions& options, const PathCheckpoint& checkpoint,
                    Progress& progress);

}  // namespace kappamu::inverse::distributed
