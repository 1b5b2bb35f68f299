#include "inverse/uncertainty/sensitivity.h"

#include <cmath>
#include <random>
#include <vector>

namespace kappamu::inverse {

CoefficientPair estimate_sensitivity(Objective& objective, int probes, std::uint64_t seed) {
  const std::size_t cells = objective.problem().setup.shape.cells();
  CoefficientPair root{std::vector<double>(cells, 0.0), std::vector<double>(cells, 0.0)};
  std::mt19937_64 engine(seed);
  std::vector<double> signs(objective.problem().data.size());
  for (int k = 0; k < probes; ++k) {
    for (double& s : signs) s = (engine() >> 63) != 0 ? 1.0 : -1.0;
    const CoefficientPair row = objective.jacobian_transpose(signs);
    for (std::size_t i = 0; i < cells; ++i) {
      root.log_kappa[i] += row.log_kappa[i] * row.log_kappa[i] / probes;
      root.log_mu[i] += row.log_mu[i] * row.log_mu[i] / probes;
    }
  }
  for (double& x : root.log_kappa) x = std::sqrt(x);
  for (double& x : root.log_mu) x = std::sqrt(x);
  return root;
}

}  // namespace kappamu::inverse
