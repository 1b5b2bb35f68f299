// An answer corrected by short random walks. Walk over answer is a factor that varies slowly: it is
// averaged with smooth weights, each average moved towards 1 as far as its noise exceeds the
// answer's own error, and interpolated by the same weights.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward {

/// The walk's noise in the cells of the lattice, relative and the same everywhere, that leaves
/// `wanted` of an error; 0: none does.
double noise_that_leaves(double error, double wanted);

struct CorrectedAnswer {
  std::vector<double> exitance;  ///< per sample
  double left = 0.0;             ///< of the relative error, 2-norm over the surface
};

class Correction {
 public:
  explicit Correction(const Surface& surface);

  /// Exitance of one light, `answer`, of relative error `error`, corrected by a walk with standard
  /// errors. Its integral is the walk's, whose noise is small there.
  CorrectedAnswer corrected(std::span<const double> answer, std::span<const double> walk,
                            std::span<const double> standard_error, double error) const;

  /// Relative error that is left of `error`, without the answer.
  double left(std::span<const double> answer, std::span<const double> walk,
              std::span<const double> standard_error, double error) const;

 private:
  /// Trilinear weights of the position times squared components of the normal: they sum to 1.
  struct Share {
    int node = 0;
    float weight = 0.0F;
  };
  /// About one node.
  struct Average {
    double answer = 0.0, walk = 0.0;  ///< ∫ weight · exitance dA
    double square = 0.0;              ///< ∫ weight · answer² dA
    double noise = 0.0;               ///< variance of the factor
  };
  std::vector<Average> averages(std::span<const double> answer, std::span<const double> walk,
                                std::span<const double> standard_error) const;
  static double left_by(const std::vector<Average>& averages, double error);

  const Surface& surface_;
  std::vector<std::array<Share, 24>> shares_;  ///< per sample
  std::size_t nodes_ = 0;  ///< of a lattice over the object's box, one for each side faced
};

}  // namespace kappamu::forward
