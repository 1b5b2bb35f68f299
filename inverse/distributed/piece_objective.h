// What a fit minimises at one weight, ½ χ² + α R with R that of H1 (regulariser/roughness.h), of a
// block cut between ranks: each computes the data term and the regulariser of its own piece by the
// code that a whole block is fitted with, and sums over ranks join them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "forward/distributed/block_pieces.h"
#include "inverse/block_model/homogeneous.h"
#include "inverse/problem/objective.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse::distributed {

using forward::distributed::BlockPieces;

/// The piece's part of a problem: one channel's data, with the weights of make_problem(). Data that
/// another rank owns have weight 0, and so has light on the halo. `measured` has one channel, the
/// piece's grid and arrays.
Problem piece_problem(const BlockPieces& pieces, const SurfaceMeasurements& measured,
                      forward::Convention convention, const ModelError& error);

/// find_homogeneous() of the whole block, on the first rank alone and from data averaged over 2^n
/// pixels where there are many. Throws InputError on all ranks.
HomogeneousFit find_start(const BlockPieces& pieces, const Problem& problem);

class PieceObjective {
 public:
  PieceObjective(std::shared_ptr<const BlockPieces> pieces, Problem problem, Backend backend,
                 const Anchor& anchor);

  /// Own voxels: log κ, then log μ.
  std::size_t size() const { return 2 * pieces_->owned().cells(); }
  const BlockPieces& pieces() const { return *pieces_; }
  void set_weight(double weight) { weight_ = weight; }

  /// Over all ranks; infinite where nothing can be solved, on all ranks alike.
  double value(std::span<const double> own);
  /// At the last value(), where that was finite.
  void gradient(std::span<double> own);

  double chi2_per_value() const { return 2.0 * misfit_ / used_; }
  double roughness() const { return roughness_.value; }
  double used() const { return used_; }
  const SolveCount& solves() const { return objective_.solves(); }
  std::string backend_name() const { return objective_.backend_name(); }
  const CoefficientPair& fields() const { return fields_; }  ///< of the piece, at the last value()
  std::vector<double> prediction() const { return objective_.prediction(); }

 private:
  std::shared_ptr<const BlockPieces> pieces_;
  Objective objective_;
  Anchor anchor_;
  double weight_ = 0.0;
  double used_ = 0.0;  ///< data of all ranks
  CoefficientPair fields_;
  double misfit_ = 0.0;  ///< ½ χ²
  Roughness roughness_;  ///< value of all ranks, gradient of the piece
};

}  // namespace kappamu::inverse::distributed
