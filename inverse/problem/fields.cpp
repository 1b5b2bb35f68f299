#include "inverse/problem/fields.h"

#include <cmath>

#include "core/parallel.h"

namespace kappamu::inverse {

std::vector<double> exponential(const std::vector<double>& log) {
  std::vector<double> value(log.size());
  for_pieces(log.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) value[i] = std::exp(log[i]);
  });
  return value;
}

Medium to_medium(const CoefficientPair& fields, const GridShape& shape) {
  Medium medium{Volume<double>(shape), Volume<double>(shape)};
  medium.kappa.values() = exponential(fields.log_kappa);
  medium.mu.values() = exponential(fields.log_mu);
  return medium;
}

CoefficientPair to_fields(const Medium& medium) {
  CoefficientPair fields;
  for (const double k : medium.kappa.values()) fields.log_kappa.push_back(std::log(k));
  for (const double m : medium.mu.values()) fields.log_mu.push_back(std::log(m));
  return fields;
}

}  // namespace kappamu::inverse
