// Closed forms on a sphere with φ + 2Aκ ∂φ/∂n = q: modified spherical Bessel functions i_l, k_l of
// the radius times Legendre polynomials of the angle.
#pragma once

#include <cmath>
#include <vector>

#include "core/object_medium.h"

namespace kappamu::forward::embedded {

struct ExactSphere {
  double radius = 1.0;  ///< [mm]
  Coefficients medium;
  double A = 1.0;

  double decay() const { return std::sqrt(medium.mu / medium.kappa); }

  /// φ on the surface where q = P_l(cos): that of q times this.
  double lit_from_outside(int l) const {
    const double x = decay() * radius;
    return i(l, x) / (i(l, x) + 2.0 * A * medium.kappa * decay() * di(l, x));
  }
  /// φ on the surface under a point source of unit power at distance s from the centre: the
  /// coefficients of P_l of the angle to it.
  std::vector<double> lit_from_inside(double s) const {
    const double x = decay() * radius, robin = 2.0 * A * medium.kappa * decay();
    std::vector<double> terms;
    for (int l = 0; l < 40; ++l) {
      const double reflected = -(k(l, x) + robin * dk(l, x)) / (i(l, x) + robin * di(l, x));
      terms.push_back(decay() / (4.0 * M_PI * medium.kappa) * (2 * l + 1) * i(l, decay() * s) *
                      (k(l, x) + reflected * i(l, x)));
    }
    return terms;
  }
  static double legendre_sum(const std::vector<double>& terms, double cosine) {
    double sum = 0.0, before = 0.0, legendre = 1.0;
    for (std::size_t l = 0; l < terms.size(); ++l) {
      sum += terms[l] * legendre;
      const double n = static_cast<double>(l);
      const double next = ((2 * n + 1) * cosine * legendre - n * before) / (n + 1);
      before = legendre;
      legendre = next;
    }
    return sum;
  }

 private:
  /// i_l by its power series.
  static double i(int l, double x) {
    double term = 1.0;
    for (int m = 1; m <= l; ++m) term *= x / (2 * m + 1);
    double sum = 0.0;
    for (int m = 1; m < 200; ++m) {
      sum += term;
      term *= x * x / (2.0 * m * (2 * (l + m) + 1));
    }
    return sum;
  }
  /// k_l with k_0 = e^−x/x, by upward recurrence.
  static double k(int l, double x) {
    double below = std::exp(-x) / x, here = below * (1.0 + 1.0 / x);
    if (l == 0) return below;
    for (int m = 1; m < l; ++m) {
      const double next = below + (2 * m + 1) / x * here;
      below = here;
      here = next;
    }
    return here;
  }
  static double di(int l, double x) { return i(l + 1, x) + l / x * i(l, x); }
  static double dk(int l, double x) { return -k(l + 1, x) + l / x * k(l, x); }
};

}  // namespace kappamu::forward::embedded
