// The area of a circle in a rectangle, in closed form: what a hair covers of a texel.
#pragma once

namespace kappamu::forward::shells {

/// Area of the disc of `radius` about the origin where u < x and v < y.
double disc_below(double radius, double x, double y);

/// Area of that disc in [x0, x1] × [y0, y1]. Exact but for rounding, which is below 1e-14 radius².
double disc_in_rectangle(double radius, double x0, double y0, double x1, double y1);

}  // namespace kappamu::forward::shells
