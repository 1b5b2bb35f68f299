#include "inverse/problem/fields.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/elementary.h"
#include "core/parallel.h"

namespace kappamu::inverse {

std::vector<double> exponential(const std::vector<double>& log) {
  std::vector<double> value(log.size());
  for_ranges(log.size(), [&](std::size_t begin, std::size_t end) {
    std::copy(log.data() + begin, log.data() + end, value.data() + begin);
    exponentiate({value.data() + begin, end - begin});
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
