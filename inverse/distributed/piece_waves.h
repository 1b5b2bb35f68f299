// The lateral waves of a block cut between ranks (optimise/lateral_modes.h): each rank has those of
// some bins of frequency, all depths of them, so that the fit's metric is the single machine's.
//
// Cosines across the light need whole planes. The rectangles of all ranks are gathered to planes,
// some a rank, transformed there, and sent on to the ranks of their bins.
#pragma once

#include <span>
#include <vector>

#include "forward/distributed/block_pieces.h"
#include "forward/distributed/plane_exchange.h"
#include "inverse/optimise/basis.h"

namespace kappamu::inverse::distributed {

using forward::distributed::BlockPieces;

/// Fields are those of the rank's own voxels. Every call is collective.
class PieceWaves final : public LateralWaves {
 public:
  explicit PieceWaves(const BlockPieces& pieces);

  int depth() const override { return modes_.depth(); }
  int waves() const override { return first_wave_[rank_ + 1] - first_wave_[rank_]; }
  int bins() const override { return static_cast<int>(members_.size()); }
  const std::vector<int>& members(int bin) const override {
    return members_[static_cast<std::size_t>(bin)];
  }
  double mean_laplacian(int bin) const override {
    return modes_.mean_laplacian(first_bin_[rank_] + bin);
  }
  Eigen::MatrixXd analyse(const CoefficientPair& own) const override;
  CoefficientPair synthesise(const Eigen::MatrixXd& coefficients) const override;

  /// lateral_blocks() of the rank's bins, of `rows` of all ranks.
  LateralBlocks blocks(std::span<const CoefficientPair> rows) const;

 private:
  /// f(the rank's own voxel, its place in the parts of planes of one coefficient)
  template <class F>
  void for_parts(F f) const;
  LateralBlocks with_neighbours(LateralBlocks sums, std::span<const int> begin,
                                std::span<const int> end) const;

  MPI_Comm comm_;
  std::size_t rank_ = 0;
  int ranks_ = 1;
  forward::distributed::Box owned_;
  LateralModes modes_;
  int depth_axis_, axis_a_, axis_b_, na_, nb_;
  CosineTransform cosines_a_, cosines_b_;
  forward::distributed::PlaneExchange planes_;
  std::vector<int> first_bin_, first_wave_;  ///< of every rank, and an end
  std::vector<int> order_;                   ///< all waves, bin by bin
  std::vector<std::vector<int>> members_;    ///< of the rank's own bins
};

}  // namespace kappamu::inverse::distributed
