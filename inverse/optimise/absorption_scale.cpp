#include "inverse/optimise/absorption_scale.h"

#include <cmath>
#include <numeric>
#include <vector>

#include "core/parallel.h"

namespace kappamu::inverse {

/// value = each(value, index) of all voxels.
template <class Each>
void AbsorptionScale::for_mu(std::vector<double>& values, const Each& each) const {
  if (mu_ == 0.0) return;
  for_pieces(values.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) values[i] = each(values[i], i);
  });
}

CoefficientPair AbsorptionScale::from_fields(CoefficientPair fields) const {
  const double log_scale = std::log(mu_);
  for_mu(fields.log_mu, [&](double m, std::size_t) { return std::sinh(m - log_scale); });
  return fields;
}

CoefficientPair AbsorptionScale::to_fields(CoefficientPair scaled) const {
  const double log_scale = std::log(mu_);
  for_mu(scaled.log_mu, [&](double w, std::size_t) { return log_scale + std::asinh(w); });
  return scaled;
}

CoefficientPair AbsorptionScale::by_scaled(const CoefficientPair& fields,
                                           CoefficientPair by_fields) const {
  const double log_scale = std::log(mu_);
  for_mu(by_fields.log_mu, [&](double change, std::size_t i) {
    return change / std::cosh(fields.log_mu[i] - log_scale);
  });
  return by_fields;
}

double AbsorptionScale::mean_slope(const CoefficientPair& fields) const {
  if (mu_ == 0.0) return 1.0;
  std::vector<double> ones(fields.log_mu.size(), 1.0);
  const std::vector<double> slope = by_scaled(fields, {{}, std::move(ones)}).log_mu;
  const double squares = std::inner_product(slope.begin(), slope.end(), slope.begin(), 0.0);
  return std::sqrt(squares / static_cast<double>(slope.size()));
}

}  // namespace kappamu::inverse
