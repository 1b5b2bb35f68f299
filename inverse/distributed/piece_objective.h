// What a fit minimises at one weight, ½ χ² + α R, of a block cut between ranks: each computes the
// data term and the regulariser of its own piece by the code that a whole block is fitted with, and
// sums over ranks join them.
#pragma once

#include <cstdint>
#include <vector>

#include "inverse/data_checks/shared_errors.h"
#include "inverse/distributed/piece_problem.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse::distributed {

/// As loose as the data allow: GridPath::open(). Collective.
Backend as_loose_as_data(Backend backend, const PieceGrid& grid);

/// Every call is collective but those that return what is kept. Fields and gradients are those of
/// the rank's own voxels.
class PieceObjective {
 public:
  /// Corrected by `refinement`, or not where that is empty.
  PieceObjective(const PieceGrid& grid, PieceRefinement refinement, Backend backend,
                 const DataTermOptions& data_term, const Anchor& anchor,
                 const Regulariser& regulariser);

  const BlockPieces& pieces() const { return *pieces_; }
  void set_derivative_tolerance(double tolerance) {
    objective_.set_derivative_tolerance(tolerance);
  }
  void set_weight(double weight) { weight_ = weight; }
  double weight() const { return weight_; }

  /// Over all ranks; infinite where nothing can be solved, on all ranks alike.
  double value(const CoefficientPair& own);
  /// At the last value(), where that was finite.
  CoefficientPair gradient();
  /// Of R alone there.
  CoefficientPair roughness_gradient() const { return own_of(roughness_gradient_); }
  /// smoothing_product() of the change `own`, with the diffusivity of the last value().
  CoefficientPair smoothing(const CoefficientPair& own) const;
  /// random_rows(), of the same signs on any number of ranks.
  std::vector<CoefficientPair> random_rows(int probes, std::uint64_t seed);
  /// r anew at these fields; χ² per value with it.
  double renew_correction(const CoefficientPair& own);

  /// shared_errors() of all ranks, by the last prediction.
  SharedErrors shared_errors() const;
  bool shares_errors() const { return !objective_.problem().smooth_error.none(); }
  /// DataTerm::chi2_per_value of all ranks.
  double chi2_per_value() const { return chi2_; }
  double roughness() const { return roughness_; }
  double used() const { return used_; }
  const SolveCount& solves() const { return objective_.solves(); }
  void count(const SolveCount& before);
  std::string backend_name() const { return objective_.backend_name(); }
  const CoefficientPair& fields() const { return fields_; }  ///< of the piece, at the last value()
  /// [M][v][u] of the piece's seen face, at the last value(); 0 off the rank's own.
  std::vector<double> prediction() const { return objective_.prediction(); }

 private:
  CoefficientPair own_of(const CoefficientPair& piece) const;
  CoefficientPair piece_of(const CoefficientPair& own) const;
  void set_misfit(double of_piece);
  void set_roughness();

  std::shared_ptr<const BlockPieces> pieces_;
  std::shared_ptr<const BlockPieces> split_;  ///< of the refinement; null: none
  Refinement refinement_;
  Objective objective_;
  DataTermOptions data_term_;
  Anchor anchor_;
  Regulariser regulariser_;
  double weight_ = 0.0;
  double used_ = 0.0;       ///< data of all ranks
  CoefficientPair fields_;  ///< of the piece, at the last value()
  bool solved_ = false;     ///< there
  double misfit_ = 0.0;     ///< the data term; ½ χ² of the Gaussian loss
  double chi2_ = 0.0;       ///< per value
  double roughness_ = 0.0;
  CoefficientPair roughness_gradient_;  ///< of the piece, right but in the halo
  std::vector<double> diffusivity_;     ///< of the piece
};

}  // namespace kappamu::inverse::distributed
