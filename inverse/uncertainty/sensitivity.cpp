#include "inverse/uncertainty/sensitivity.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/error.h"

namespace kappamu::inverse {

CoefficientPair estimate_sensitivity(std::span<const CoefficientPair> rows) {
  check(!rows.empty(), "sensitivity: no rows");
  const std::size_t cells = rows.front().log_kappa.size();
  const auto count = static_cast<double>(rows.size());
  CoefficientPair root{std::vector<double>(cells, 0.0), std::vector<double>(cells, 0.0)};
  for (const CoefficientPair& row : rows) {
    for (std::size_t i = 0; i < cells; ++i) {
      root.log_kappa[i] += row.log_kappa[i] * row.log_kappa[i] / count;
      root.log_mu[i] += row.log_mu[i] * row.log_mu[i] / count;
    }
  }
  for (double& x : root.log_kappa) x = std::sqrt(x);
  for (double& x : root.log_mu) x = std::sqrt(x);
  return root;
}

}  // namespace kappamu::inverse
