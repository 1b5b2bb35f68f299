#include "forward/choice/error_belief.h"

#include <array>
#include <cmath>
#include <numeric>

namespace kappamu::forward {

double error_quantile(const ErrorBelief& belief, double probability) {
  // Deviations of the logarithm from the law, weighed by the measurement.
  constexpr double farthest = 5.0, step = 0.01;
  constexpr auto steps = static_cast<std::size_t>(2.0 * farthest / step);
  const auto deviation = [&](std::size_t i) {
    return (static_cast<double>(i) + 0.5) * step - farthest;
  };
  const auto error = [&](double x) { return belief.law * std::exp(belief.spread * x); };
  std::array<double, steps> weight{};
  for (std::size_t i = 0; i < steps; ++i) {
    const double x = deviation(i);
    const double off = belief.square_deviation > 0.0
                           ? (error(x) * error(x) - belief.square) / belief.square_deviation
                           : 0.0;
    weight[i] = std::exp(-0.5 * (x * x + off * off));
  }
  double left = probability * std::accumulate(weight.begin(), weight.end(), 0.0);
  for (std::size_t i = 0; i < steps; ++i) {
    if (left <= weight[i]) {
      return error(deviation(i) + step * (weight[i] > 0.0 ? left / weight[i] - 0.5 : 0.0));
    }
    left -= weight[i];
  }
  return error(farthest);
}

}  // namespace kappamu::forward
