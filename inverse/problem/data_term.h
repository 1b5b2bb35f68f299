// What a misfit costs: Σ ρ(√w (g p − d)) over data d with weights w, p = r M the prediction, ρ the
// loss, and g a gain per pattern that is profiled out where it is asked for. Costs no solve.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "inverse/problem/problem.h"

namespace kappamu::inverse {

/// Of the residual e in standard deviations. The robust two limit the pull of a wild datum.
enum class Loss {
  gaussian,  ///< ½ e²
  huber,     ///< ½ e² up to c, then c |e| − ½ c² (Huber 1964): the pull of a datum ends at c
  student    ///< ½ (ν + 1) log(1 + e²/ν): the pull falls to nothing
};
std::string to_string(Loss loss);

struct DataTermOptions {
  Loss loss = Loss::gaussian;
  double huber_threshold = 1.345;  ///< c: 95 % of the Gaussian's efficiency on Gaussian noise
  double student_freedom = 4.0;    ///< ν
  /// Spread s of a gain g per pattern about 1, such as a projector's drift: adds ½ ((g − 1)/s)² and
  /// minimises over g [relative]. Unset: g = 1.
  std::optional<double> gain_spread;
};

/// Throws InputError naming option, value and bound.
void validate(const DataTermOptions& options);

struct DataTerm {
  double value = 0.0;  ///< the sum, gains' own cost included; infinite where p is not finite
  /// χ² per value used: mean e², under a robust loss (median |e| / 0.6745)², which wild data do not
  /// move.
  double chi2_per_value = 0.0;
  std::vector<double> gains;          ///< [M]
  std::vector<double> by_prediction;  ///< ∂value/∂p: the gains are at their minimum
  /// Square root of the weight that Gauss-Newton gives p: √(w ψ(e)/e) g, ψ = ρ'.
  std::vector<double> root_weight;
};

/// `prediction` [M][v][u] as problem.data.
DataTerm evaluate(const Problem& problem, const std::vector<double>& prediction,
                  const DataTermOptions& options);

}  // namespace kappamu::inverse
