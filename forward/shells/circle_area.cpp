#include "forward/shells/circle_area.h"

#include <cmath>
#include <numbers>

namespace kappamu::forward::shells {

namespace {

using std::numbers::pi;

/// Of the unit disc, ∫ √(1−v²) dv from 0 to y.
double strip(double y) {
  return 0.5 * (y * std::sqrt(1.0 - y * y) + std::asin(y));
}

/// Of the unit disc, where v < y.
double segment(double y) {
  return y >= 1.0 ? pi : 2.0 * strip(y) + 0.5 * pi;
}

}  // namespace

double disc_below(double radius, double x, double y) {
  const double u = x / radius, v = y / radius, square = radius * radius;
  if (u <= -1.0 || v <= -1.0) return 0.0;
  if (u >= 1.0) return square * segment(v);
  if (v >= 1.0) return square * segment(u);
  if (u * u + v * v < 1.0) return square * (u * v + 0.25 * pi + strip(u) + strip(v));
  if (u > 0.0 && v > 0.0) return square * (segment(u) + segment(v) - pi);
  if (u > 0.0) return square * segment(v);
  return v > 0.0 ? square * segment(u) : 0.0;
}

double disc_in_rectangle(double radius, double x0, double y0, double x1, double y1) {
  return disc_below(radius, x1, y1) - disc_below(radius, x0, y1) - disc_below(radius, x1, y0) +
         disc_below(radius, x0, y0);
}

}  // namespace kappamu::forward::shells
