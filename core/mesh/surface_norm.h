// Differences of what is given per sample of a surface, in its 2-norm.
#pragma once

#include <cmath>
#include <span>

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

/// √(∫ (a − b)² dA) over the surface.
inline double surface_difference(const Surface& surface, std::span<const double> a,
                                 std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    sum += surface.area[t] * (a[t] - b[t]) * (a[t] - b[t]);
  }
  return std::sqrt(sum);
}

/// √(∫ a² dA).
inline double surface_norm(const Surface& surface, std::span<const double> a) {
  double sum = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) sum += surface.area[t] * a[t] * a[t];
  return std::sqrt(sum);
}

}  // namespace kappamu
