// FitFunction (optimise/fit_function.h) of a block cut between ranks: each has a part of the
// coordinates.
#pragma once

#include "inverse/distributed/distributed_fit.h"
#include "inverse/distributed/piece_objective.h"
#include "inverse/distributed/piece_waves.h"
#include "inverse/optimise/absorption_scale.h"
#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse::distributed {

/// AbsorptionScale::mean_slope() of all ranks.
double mean_slope(const BlockPieces& pieces, const AbsorptionScale& scale,
                  const CoefficientPair& own);
/// Σ a b over all ranks.
double product(const BlockPieces& pieces, const Vector& a, const Vector& b);

/// At the objective's weight. Every call is collective.
class PieceFunction final : public Function {
 public:
  PieceFunction(PieceObjective& objective, const Basis& basis, const AbsorptionScale& scale,
                CoefficientPair start);

  Vector coordinates(const CoefficientPair& own) const;
  CoefficientPair fields(const Vector& z) const;

  double value(const Vector& z) override;
  Vector gradient() override;
  double amplitude(const Vector& z, const Vector& direction) override;
  /// An L-BFGS pair of this function's coordinates, of the fields.
  FieldPair to_fields(const std::vector<float>& step, const std::vector<float>& change) const;
  /// FitFunction::adopt() of a pair of the fields that was learned at the weight `before`.
  void adopt(double before, Vector& step, Vector& change) const;
  void total(std::span<double> products) const override;
  /// As FitFunction's, at the fields of the last value().
  double chi2_gain(const Basis& basis, double weight) const;

 private:
  bool alike(const Vector& a, const Vector& b) const;

  PieceObjective& objective_;
  const Basis& basis_;
  AbsorptionScale scale_;
  CoefficientPair start_;
  Vector start_z_;
  Vector here_z_;
  CoefficientPair here_;  ///< fields of the last value()
};

}  // namespace kappamu::inverse::distributed
