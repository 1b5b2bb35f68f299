#include "core/optics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu {

namespace {

/// Unpolarised reflectance from the cosines on both sides; `ratio` = index on the near side / far
/// side.
double fresnel(double ratio, double cos_near, double cos_far) {
  const double parallel = (cos_near - ratio * cos_far) / (cos_near + ratio * cos_far);
  const double perpendicular = (ratio * cos_near - cos_far) / (ratio * cos_near + cos_far);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

/// Five-point Gauss-Legendre rule on each of `panels` equal parts of [a, b].
template <class F>
double integrate(F f, double a, double b, int panels) {
  constexpr std::array<double, 5> node{-0.9061798459386640, -0.5384693101056831, 0.0,
                                       0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 5> weight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                         0.4786286704993665, 0.2369268850561891};
  const double width = (b - a) / panels;
  double sum = 0.0;
  for (int p = 0; p < panels; ++p) {
    for (std::size_t i = 0; i < node.size(); ++i) {
      sum += weight[i] * f(a + width * (p + 0.5 * (1.0 + node[i])));
    }
  }
  return 0.5 * width * sum;
}

}  // namespace

double fresnel_internal(double eta, double cos_inside) {
  const double sin2_outside = eta * eta * (1.0 - cos_inside * cos_inside);
  if (sin2_outside >= 1.0) return 1.0;
  return fresnel(eta, cos_inside, std::sqrt(1.0 - sin2_outside));
}

double fresnel_external(double eta, double cos_outside) {
  const double sin2_inside = (1.0 - cos_outside * cos_outside) / (eta * eta);
  return fresnel(1.0 / eta, cos_outside, std::sqrt(1.0 - sin2_inside));
}

BoundaryConstants boundary_constants(double eta) {
  if (!(eta >= 1.0 && eta <= 4.0)) throw InputError("eta must lie between 1 and 4");
  BoundaryConstants constants;
  constants.eta = eta;
  const double cos_critical = std::sqrt(std::max(0.0, 1.0 - 1.0 / (eta * eta)));
  // Below the critical cosine R = 1. Above it R leaves 1 like a square root, so integrate over s
  // with c = cos_critical + (1 − cos_critical) s², which makes the integrand smooth.
  const auto moment = [&](int power) {
    const auto integrand = [&](double s) {
      const double c = cos_critical + (1.0 - cos_critical) * s * s;
      return (power + 1) * std::pow(c, power) * fresnel_internal(eta, c) * 2.0 *
             (1.0 - cos_critical) * s;
    };
    return std::pow(cos_critical, power + 1) + integrate(integrand, 0.0, 1.0, 64);
  };
  constants.r_phi = moment(1);
  constants.r_j = moment(2);
  constants.A = (1.0 + constants.r_j) / (1.0 - constants.r_phi);
  constants.normal_transmittance = 1.0 - fresnel_external(eta, 1.0);
  return constants;
}

double fdr_polynomial(double eta) {
  return -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
}

double radiance_per_exitance(const BoundaryConstants& constants, double cos_outside) {
  const double eta = constants.eta;
  const double cos_inside = std::sqrt(1.0 - (1.0 - cos_outside * cos_outside) / (eta * eta));
  return (1.0 - fresnel_external(eta, cos_outside)) / (eta * eta) *
         (2.0 * constants.A + 3.0 * cos_inside) / (4.0 * std::numbers::pi);
}

}  // namespace kappamu
