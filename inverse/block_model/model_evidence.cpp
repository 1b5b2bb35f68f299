#include "inverse/block_model/model_evidence.h"

#include <algorithm>
#include <cmath>

#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::model_evidence;

}  // namespace

Evidence weigh(const Problem& problem, const std::vector<double>& prediction,
               const ModelError& model_error) {
  const FaceShape face = problem.seen_shape();
  std::vector<double> residual(prediction.size());
  for (std::size_t i = 0; i < residual.size(); ++i) {
    residual[i] = std::sqrt(problem.weight[i]) * (prediction[i] - problem.data[i]);
  }
  Evidence evidence;
  double squares = 0.0;
  double product = 0.0;
  double both = 0.0;
  std::size_t pairs = 0;
  const auto add = [&](std::size_t i, std::size_t j) {
    if (problem.weight[i] <= 0.0 || problem.weight[j] <= 0.0) return;
    product += residual[i] * residual[j];
    both += 0.5 * (residual[i] * residual[i] + residual[j] * residual[j]);
    ++pairs;
  };
  std::size_t i = 0;
  double systematic = 0.0;
  for (int m = 0; m < problem.patterns; ++m) {
    double largest = 0.0;
    for (std::size_t k = i; k < i + face.cells(); ++k) {
      if (problem.weight[k] > 0.0) largest = std::max(largest, std::abs(problem.data[k]));
    }
    const double floor = model_error.of_maximum * largest;
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u, ++i) {
        if (problem.weight[i] <= 0.0) continue;
        ++evidence.data;
        squares += residual[i] * residual[i];
        const double relative = model_error.relative * problem.data[i];
        const double of_r =
            problem.correction_variance.empty() ? 0.0 : problem.correction_variance[i];
        systematic += problem.weight[i] * (relative * relative + floor * floor + of_r);
        if (u + 1 < face.nu) add(i, i + 1);
        if (v + 1 < face.nv) add(i, i + static_cast<std::size_t>(face.nu));
      }
    }
  }
  if (evidence.data > 0) {
    evidence.chi2_per_value = squares / static_cast<double>(evidence.data);
    evidence.systematic = systematic / static_cast<double>(evidence.data);
  }
  if (pairs > 0 && both > 0.0) {
    evidence.coherence = product / both;
    evidence.coherence_error = 1.0 / std::sqrt(static_cast<double>(pairs));
  }
  return evidence;
}

double coherent_limit(const Evidence& evidence, double tolerated) {
  return tolerated + evidence.systematic +
         deviations * evidence.coherence_error * evidence.chi2_per_value;
}

double chi2_limit(std::size_t data, double tolerated) {
  return 1.0 + tolerated + deviations * std::sqrt(2.0 / static_cast<double>(data));
}

bool not_rejected(const Evidence& evidence, double tolerated) {
  return evidence.chi2_per_value <= chi2_limit(evidence.data, tolerated) &&
         evidence.coherent() <= coherent_limit(evidence, tolerated);
}

}  // namespace kappamu::inverse
