#include "capture/stray_light.h"

#include <algorithm>

#include "core/error.h"

namespace kappamu::capture {

std::optional<double> stray_light(std::span<const double> published,
                                  std::span<const double> measured) {
  check(published.size() == measured.size(), "every patch has both reflectances");
  constexpr std::size_t fewest = 3;
  if (published.size() < fewest || *std::min_element(measured.begin(), measured.end()) <= 0.0) {
    return std::nullopt;
  }
  // Normal equations of (a p + b)/m = 1.
  double pp = 0.0;
  double p1 = 0.0;
  double one = 0.0;
  double p = 0.0;
  double b = 0.0;
  for (std::size_t k = 0; k < published.size(); ++k) {
    const double m = measured[k];
    pp += published[k] * published[k] / (m * m);
    p1 += published[k] / (m * m);
    one += 1.0 / (m * m);
    p += published[k] / m;
    b += 1.0 / m;
  }
  const double slope = p * one - b * p1;  // both over the same determinant
  const double offset = pp * b - p1 * p;
  if (!(slope > 0.0)) return std::nullopt;
  return offset / slope;
}

}  // namespace kappamu::capture
