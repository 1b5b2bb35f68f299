// Whether residuals look like noise: what a model must pass not to be rejected by the data.
#pragma once

#include <cstddef>
#include <vector>

#include "inverse/problem/problem.h"

namespace kappamu::inverse {

/// Statistics of the residuals s = √w (r M − d), whose variance is 1 where model and variances are
/// right.
struct Evidence {
  std::size_t data = 0;
  double chi2_per_value = 0.0;
  /// Correlation of residuals of neighbouring pixels of a pattern [dimensionless]. Noise of
  /// different pixels is independent and light in the block is smooth: the
  /// model's remaining misfit appears here, as its share of χ², whatever the stated variances.
  double coherence = 0.0;
  double coherence_error = 1.0;  ///< its standard deviation under noise alone
  double systematic =
      0.0;  ///< mean share of the variances that is the model's own error, r's noise with it

  /// Variance of the misfit that neighbours share, in those stated.
  double coherent() const { return coherence * chi2_per_value; }
};

/// `prediction` [M][v][u], as `problem.data`; `model_error` is what the problem was made with.
Evidence weigh(const Problem& problem, const std::vector<double>& prediction,
               const ModelError& model_error);

/// Bound of coherent(): three standard deviations of noise, the model's own error, and `tolerated`,
/// a share of the stated variance.
double coherent_limit(const Evidence& evidence, double tolerated);

/// The same of χ² per value.
double chi2_limit(std::size_t data, double tolerated);

/// Neither χ² nor its coherent part exceeds what noise, the model's own error and `tolerated`
/// explain.
bool not_rejected(const Evidence& evidence, double tolerated);

}  // namespace kappamu::inverse
