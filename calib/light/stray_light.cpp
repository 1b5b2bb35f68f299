#include "calib/light/stray_light.h"

namespace kappamu::calib {

std::optional<double> stray_light(const ChartReference& chart, std::size_t channel) {
  // Normal equations of (a p + b)/m = 1.
  double pp = 0.0;
  double p1 = 0.0;
  double one = 0.0;
  double p = 0.0;
  double b = 0.0;
  int patches = 0;
  for (const NeutralPatch& neutral : chart.neutrals) {
    if (channel >= neutral.measured.size()) continue;
    const double m = neutral.measured[channel];
    if (m <= 0.0) return std::nullopt;
    pp += neutral.published * neutral.published / (m * m);
    p1 += neutral.published / (m * m);
    one += 1.0 / (m * m);
    p += neutral.published / m;
    b += 1.0 / m;
    ++patches;
  }
  constexpr int fewest = 3;
  const double slope = p * one - b * p1;  // both over the same determinant
  const double offset = pp * b - p1 * p;
  if (patches < fewest || !(slope > 0.0)) return std::nullopt;
  return offset / slope;
}

}  // namespace kappamu::calib
