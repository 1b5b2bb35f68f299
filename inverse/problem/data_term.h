// The data term Σ ρ(e) over data d with weights w, e = √w (p − d), p = r M the prediction, ρ
// the loss; with errors that neighbours share (smooth_error.h) ½ eᵀ (I + S)⁻¹ e. A robust loss
// takes all data for independent. Costs no solve.
#pragma once

#include <string>
#include <vector>

#include "core/names.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

/// ρ of the residual e in standard deviations. The robust two limit the pull of an outlier.
enum class Loss {
  gaussian,  ///< ½ e²
  huber,     ///< ½ e² up to c, then c |e| − ½ c² (Huber 1964): the pull of a datum ends at c
  student    ///< ½ (ν + 1) log(1 + e²/ν): the pull falls to nothing
};
inline constexpr Names<Loss, 3> loss_names{
    {{"gaussian", Loss::gaussian}, {"huber", Loss::huber}, {"student", Loss::student}}};
inline std::string to_string(Loss loss) {
  return name_of(loss_names, loss);
}

struct DataTermOptions {
  Loss loss = Loss::gaussian;
  double huber_threshold = 1.345;  ///< c: 95 % of the Gaussian's efficiency on Gaussian noise
  double student_freedom = 4.0;    ///< ν
};

struct DataTerm {
  double value = 0.0;  ///< the sum; infinite where p is not finite
  /// χ² per value used: mean e², with shared errors eᵀ (I + S)⁻¹ e over the count, under a robust
  /// loss (median |e| / 0.6745)², which outliers do not move.
  double chi2_per_value = 0.0;
  std::vector<double> by_prediction;  ///< ∂value/∂p
  /// Square root of the weight that Gauss-Newton gives p: √(w ψ(e)/e), ψ = ρ'.
  std::vector<double> root_weight;
};

/// χ² per value under a robust loss, from the median of |e|.
double robust_chi2(double median);

/// Whether residuals have problem.precision.
bool shares_errors(const Problem& problem, const DataTermOptions& options);

/// `prediction` [M][v][u] as problem.data.
DataTerm evaluate(const Problem& problem, const std::vector<double>& prediction,
                  const DataTermOptions& options);

}  // namespace kappamu::inverse
