// The data of a block cut between ranks: each rank has those of its piece, on the grid of the
// measurements and on coarser ones.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "forward/distributed/block_pieces.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse::distributed {

using forward::distributed::BlockPieces;

/// A grid, and a rank's data on it. Data that another rank owns have weight 0, and so has light on
/// the halo.
struct PieceGrid {
  std::shared_ptr<const BlockPieces> pieces;
  Problem problem;
};

/// The piece's part of a problem: one channel's data, with the weights of make_problem(); errors
/// that pixels share are those of the whole face. `measured` has one channel, the piece's grid and
/// arrays.
Problem piece_problem(const BlockPieces& pieces, const SurfaceMeasurements& measured,
                      forward::Convention convention, const ModelError& error);
/// Those patterns alone.
PieceGrid select_patterns(const PieceGrid& all, std::span<const int> patterns);
/// Σ w d² over all ranks.
double signal_square(const PieceGrid& grid);

/// The grids of GridLevels, as far as BlockPieces::halvings() go; at most `most`.
std::vector<PieceGrid> piece_levels(PieceGrid finest, const ModelError& coarse_model_error,
                                    int most);
/// GridLevels::closer() of those; empty where that is null.
std::optional<PieceGrid> closer_of(const std::vector<PieceGrid>& levels,
                                   const ModelError& coarse_model_error);

/// A finer grid for the correction r, cut as `coarse` is: `finer`'s, or without one coarse's own
/// with every voxel split.
struct PieceRefinement {
  std::shared_ptr<const BlockPieces> pieces;
  Refinement refinement;
};
PieceRefinement piece_refinement(const PieceGrid& coarse, const PieceGrid* finer);

/// Fields of the rank's own voxels on the next finer grid.
CoefficientPair to_finer(const CoefficientPair& own, const BlockPieces& coarse,
                         const BlockPieces& finer);

/// find_homogeneous() of the whole block, on the first rank alone and from data averaged over 2^n
/// pixels where there are many. Throws InputError on all ranks.
HomogeneousFit find_start(const PieceGrid& grid, const std::optional<HomogeneousGuess>& guess);
/// The data that start is found by, the same on all ranks.
Problem whole_problem(const PieceGrid& grid);

/// The numbers that each rank's own voxels or pixels have among those of all ranks: what `share` of
/// `values` of all ranks is below; 0 where there are none.
double quantile(const BlockPieces& pieces, const std::vector<double>& values, double share);

}  // namespace kappamu::inverse::distributed
