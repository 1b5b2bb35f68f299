#include "inverse/roughness.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace kappamu::inverse {

Roughness roughness(const GridShape& shape, double thickness_mm, const CoefficientPair& fields,
                    const std::optional<Anchor>& anchor) {
  const double scale = shape.voxel_mm / thickness_mm;
  const std::size_t cells = shape.cells();
  CoefficientPair gradient{std::vector<double>(cells, 0.0), std::vector<double>(cells, 0.0)};
  const auto couple = [&](std::size_t i, std::size_t j) {
    const double by_kappa = scale * (fields.log_kappa[i] - fields.log_kappa[j]);
    const double by_mu = scale * (fields.log_mu[i] - fields.log_mu[j]);
    gradient.log_kappa[i] += by_kappa;
    gradient.log_kappa[j] -= by_kappa;
    gradient.log_mu[i] += by_mu;
    gradient.log_mu[j] -= by_mu;
  };
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const std::size_t i = shape.index(x, y, z);
        if (x + 1 < shape.nx) couple(i, shape.index(x + 1, y, z));
        if (y + 1 < shape.ny) couple(i, shape.index(x, y + 1, z));
        if (z + 1 < shape.nz) couple(i, shape.index(x, y, z + 1));
      }
    }
  }
  double value = 0.0;
  for (std::size_t i = 0; i < cells; ++i) {
    value +=
        0.5 * (fields.log_kappa[i] * gradient.log_kappa[i] + fields.log_mu[i] * gradient.log_mu[i]);
  }
  if (anchor) {
    const double pull = scale * std::pow(shape.voxel_mm / anchor->length_mm, 2);
    for (std::size_t i = 0; i < cells; ++i) {
      const double by_kappa = fields.log_kappa[i] - anchor->log_kappa;
      const double by_mu = fields.log_mu[i] - anchor->log_mu;
      value += 0.5 * pull * (by_kappa * by_kappa + by_mu * by_mu);
      gradient.log_kappa[i] += pull * by_kappa;
      gradient.log_mu[i] += pull * by_mu;
    }
  }
  return {value, std::move(gradient)};
}

}  // namespace kappamu::inverse
