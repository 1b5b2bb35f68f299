// One channel of a block cut between ranks, as inverse/fit/fit.h: from the best homogeneous block,
// grids coarse to fine, down the weights of the regulariser on the finest, by the same metric,
// optimiser and rules (path_rules.h). Of that fit it has no models of few unknowns, no transport,
// no checks of the data and no deviations.
#pragma once

#include <functional>
#include <optional>

#include "core/progress.h"
#include "inverse/distributed/piece_objective.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse::distributed {

/// What the optimiser has learned of the Hessian by one step, of the rank's own voxels: a step of
/// the fields as AbsorptionScale has them and the change of the gradient with respect to these,
/// [κ, w][z][y][x] both. So they are the same on any number of ranks.
struct FieldPair {
  std::vector<float> step, change;
};

/// Where a fit stands before a weight.
struct PathState {
  int level = 0;        ///< grid, 0 = finest
  bool closer = false;  ///< GridLevels::closer()
  double weight = 0.0;
  bool last = false;  ///< that weight ends the fit
  PathEnd end = PathEnd::unknown;
  double last_chi2 = 0.0;        ///< at the weight before on this grid
  double last_score = 0.0;       ///< cross-validation's at the same end; 0 before the first
  double seconds = 0.0;          ///< so far
  FitReport report;              ///< so far: start, history, solves
  CoefficientPair own;           ///< of this rank's voxels on that grid
  std::vector<FieldPair> pairs;  ///< of the weight before on that grid, oldest first
  double pairs_weight = 0.0;     ///< that weight
};

/// Called by all ranks, with each one's part. load() gives nothing where there is no state of this
/// fit.
struct PathCheckpoint {
  std::function<void(const PathState&)> save;
  std::function<std::optional<PathState>()> load;
};

/// A finished fit to go on from, at its weight.
struct PieceContinuation {
  CoefficientPair own;  ///< of the rank's voxels
  FitReport report;
};

struct PieceContext {
  std::optional<PieceContinuation> continued;
  bool interim = false;  ///< another fit goes on from this one: its end need not be tight
};

struct PieceFit {
  CoefficientPair fields;          ///< of the piece, halo included
  CoefficientPair own;             ///< of the rank's voxels
  std::vector<double> prediction;  ///< exitance on the piece's seen face [M][v][u]; 0 off its own
  FitReport report;
};

/// Of `options` it takes the data's model errors, the regulariser, the path but its model, and the
/// solver. Throws InputError.
PieceFit fit_pieces(const PieceGrid& data, const FitOptions& options,
                    const PathCheckpoint& checkpoint, Progress& progress,
                    const PieceContext& context = {});

/// How a volume, of the rank's own voxels, predicts data that it was not fitted to, by a grid of
/// split voxels (predict.h).
struct PieceScore {
  double chi2_per_value = 0.0;
  std::vector<double> prediction;  ///< as PieceFit's
};
PieceScore score_pieces(const PieceGrid& validation, const CoefficientPair& own,
                        const FitOptions& options);

}  // namespace kappamu::inverse::distributed
