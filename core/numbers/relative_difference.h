// How far two vectors are apart.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/error.h"

namespace kappamu {

/// ‖a − b‖₂ / ‖b‖₂, of as many numbers each.
inline double relative_difference(const std::vector<double>& a, const std::vector<double>& b) {
  check(a.size() == b.size(), "relative_difference: equal sizes");
  double difference = 0.0, norm = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    norm += b[i] * b[i];
  }
  return std::sqrt(difference / norm);
}

}  // namespace kappamu
