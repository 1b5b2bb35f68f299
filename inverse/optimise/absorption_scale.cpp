#include "inverse/optimise/absorption_scale.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "core/numbers/elementary.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

constexpr std::size_t part_length = 4096;

}  // namespace

/// Calls work(begin, end) for parts of so many voxels, on all cores; where w is not log μ itself.
template <class Work>
void AbsorptionScale::for_parts(std::size_t voxels, const Work& work) const {
  if (mu_ == 0.0) return;
  for_pieces(voxels, part_length,
             [&](std::size_t, std::size_t begin, std::size_t end) { work(begin, end); });
}

CoefficientPair AbsorptionScale::from_fields(CoefficientPair fields) const {
  const double log_scale = std::log(mu_);
  std::vector<double>& log_mu = fields.log_mu;
  for_parts(log_mu.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) log_mu[i] = std::sinh(log_mu[i] - log_scale);
  });
  return fields;
}

CoefficientPair AbsorptionScale::to_fields(CoefficientPair scaled) const {
  const double log_scale = std::log(mu_);
  std::vector<double>& log_mu = scaled.log_mu;
  for_parts(log_mu.size(), [&](std::size_t begin, std::size_t end) {
    take_arsinh({&log_mu[begin], end - begin});
    for (std::size_t i = begin; i < end; ++i) log_mu[i] += log_scale;
  });
  return scaled;
}

CoefficientPair AbsorptionScale::by_scaled(const CoefficientPair& fields,
                                           CoefficientPair by_fields) const {
  const double log_scale = std::log(mu_);
  std::vector<double>& by_mu = by_fields.log_mu;
  for_parts(by_mu.size(), [&](std::size_t begin, std::size_t end) {
    std::array<double, part_length> power{};
    for (std::size_t i = begin; i < end; ++i) power[i - begin] = fields.log_mu[i] - log_scale;
    exponentiate({power.data(), end - begin});
    // Over the hyperbolic cosine.
    for (std::size_t i = begin; i < end; ++i) {
      by_mu[i] *= 2.0 / (power[i - begin] + 1.0 / power[i - begin]);
    }
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
