#include "calib/projector/projector_curve.h"

#include <algorithm>
#include <cmath>

namespace kappamu::calib {
namespace {

/// Slopes at the knots that keep the cubic monotone where the knots are: Fritsch & Carlson 1980
/// with the harmonic mean of Fritsch & Butland 1984.
std::vector<double> monotone_slopes(const std::vector<int>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> secant(n - 1);
  for (std::size_t k = 0; k + 1 < n; ++k) secant[k] = (y[k + 1] - y[k]) / (x[k + 1] - x[k]);
  std::vector<double> slope(n, 0.0);
  slope.front() = secant.front();
  slope.back() = secant.back();
  for (std::size_t k = 1; k + 1 < n; ++k) {
    if (secant[k - 1] * secant[k] <= 0.0) continue;
    const double before = x[k] - x[k - 1];
    const double after = x[k + 1] - x[k];
    slope[k] = 3.0 * (before + after) /
               ((2.0 * after + before) / secant[k - 1] + (after + 2.0 * before) / secant[k]);
  }
  // At the ends by the parabola through three knots, unless that overshoots.
  const auto end_slope = [](double near, double far, double width, double next_width) {
    const double parabola =
        ((2.0 * width + next_width) * near - width * far) / (width + next_width);
    if (parabola * near <= 0.0) return 0.0;
    return std::copysign(std::min(std::abs(parabola), 3.0 * std::abs(near)), near);
  };
  if (n > 2) {
    slope.front() = end_slope(secant[0], secant[1], x[1] - x[0], x[2] - x[1]);
    slope.back() =
        end_slope(secant[n - 2], secant[n - 3], x[n - 1] - x[n - 2], x[n - 2] - x[n - 3]);
  }
  return slope;
}

}  // namespace

double ProjectorCurve::mean(std::size_t value) const {
  double sum = 0.0;
  for (const std::vector<double>& channel : light) sum += channel[value];
  return sum / static_cast<double>(light.size());
}

double ProjectorCurve::channel_spread() const {
  double spread = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    for (const std::vector<double>& channel : light) {
      spread = std::max(spread, std::abs(channel[k] - mean(k)));
    }
  }
  return spread;
}

ProjectorCurve curve_from_signals(const std::vector<int>& values,
                                  const std::vector<std::vector<double>>& signals) {
  ProjectorCurve curve{values, std::vector<std::vector<double>>(signals.front().size())};
  for (std::size_t c = 0; c < curve.light.size(); ++c) {
    const double black = signals.front()[c];
    for (const std::vector<double>& signal : signals) {
      curve.light[c].push_back((signal[c] - black) / (signals.back()[c] - black));
    }
  }
  return curve;
}

LightTable power_table(double exponent) {
  LightTable table{};
  for (std::size_t value = 0; value < table.size(); ++value) {
    table[value] = static_cast<float>(std::pow(static_cast<double>(value) / 255.0, exponent));
  }
  return table;
}

LightTable light_table(const std::optional<ProjectorCurve>& curve) {
  if (!curve) return power_table(1.0);
  const std::vector<int>& x = curve->values;
  std::vector<double> y(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) y[k] = curve->mean(k);
  const std::vector<double> slope = monotone_slopes(x, y);
  LightTable table{};
  for (std::size_t k = 0; k + 1 < x.size(); ++k) {
    const double width = x[k + 1] - x[k];
    for (int value = x[k]; value <= x[k + 1]; ++value) {
      const double t = (value - x[k]) / width;
      const double s = 1.0 - t;
      table[static_cast<std::size_t>(value)] =
          static_cast<float>(s * s * ((1.0 + 2.0 * t) * y[k] + t * width * slope[k]) +
                             t * t * ((1.0 + 2.0 * s) * y[k + 1] - s * width * slope[k + 1]));
    }
  }
  return table;
}

}  // namespace kappamu::calib
