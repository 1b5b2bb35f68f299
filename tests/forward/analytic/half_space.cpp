#include "tests/forward/analytic/half_space.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu::forward {

namespace {

void validate(const Material& m) {
  if (!(m.kappa > 0.0 && m.mu >= 0.0 && 3.0 * m.kappa * m.mu < 1.0)) {
    throw InputError("half-space: kappa must be positive and mu lie in 0 <= mu < 1/(3 kappa)");
  }
}

double decay_of(const Material& m) {
  return std::sqrt(m.mu / m.kappa);
}

/// κ ∂φ/∂z at the surface, distance r from the axis, of a unit point source at depth z and its
/// negative image at −(z + 2·extrapolation).
double image_pair(const Material& m, double extrapolation, double z, double r) {
  const double decay = decay_of(m);
  const auto part = [&](double height) {
    const double distance = std::hypot(height, r);
    return height * (decay + 1.0 / distance) * std::exp(-decay * distance) /
           (4.0 * std::numbers::pi * distance * distance);
  };
  return part(z) + part(z + 2.0 * extrapolation);
}

/// ∫₀^end f(t) dt, five-point Gauss-Legendre on equal panels.
template <class F>
double integrate(F f, double end, int panels) {
  constexpr std::array<double, 5> node{-0.9061798459386640, -0.5384693101056831, 0.0,
                                       0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 5> weight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                         0.4786286704993665, 0.2369268850561891};
  const double width = end / panels;
  double sum = 0.0;
  for (int p = 0; p < panels; ++p) {
    for (std::size_t i = 0; i < node.size(); ++i) {
      sum += weight[i] * f(width * (p + 0.5 * (1.0 + node[i])));
    }
  }
  return 0.5 * width * sum;
}

}  // namespace

double point_source_fluence(const Material& material, double r) {
  validate(material);
  return std::exp(-decay_of(material) * r) / (4.0 * std::numbers::pi * material.kappa * r);
}

double point_source_flux(const Material& material, double r) {
  return material.kappa * point_source_fluence(material, r) * (decay_of(material) + 1.0 / r);
}

double dipole_exitance(const Material& material, const BoundaryConstants& constants,
                       BeamSource source, double r) {
  validate(material);
  check(r > 0.0, "dipole_exitance: r must be positive");
  const double path = 3.0 * material.kappa;
  const double albedo = 1.0 - path * material.mu;
  const double extrapolation = 2.0 * constants.A * material.kappa;
  const double power = constants.normal_transmittance * albedo;
  if (source == BeamSource::one_depth) return power * image_pair(material, extrapolation, path, r);
  // z = r sinh t resolves the sources nearer than r and those beyond alike.
  constexpr double depth = 40.0;  // mean free paths; e^-40 of the beam lies deeper
  constexpr int panels = 48;
  const auto integrand = [&](double t) {
    const double z = r * std::sinh(t);
    return image_pair(material, extrapolation, z, r) * std::exp(-z / path) / path * r *
           std::cosh(t);
  };
  return power * integrate(integrand, std::asinh(depth * path / r), panels);
}

double dipole_reflectance(const Material& material, const BoundaryConstants& constants,
                          BeamSource source) {
  validate(material);
  const double decay = decay_of(material), path = 3.0 * material.kappa;
  // A plane of sources sends e^(−μ_eff z) of itself through a plane at distance z; the images add.
  const double both = 0.5 * (1.0 + std::exp(-4.0 * constants.A * material.kappa * decay));
  const double reaching =
      source == BeamSource::one_depth ? std::exp(-decay * path) : 1.0 / (1.0 + decay * path);
  return constants.normal_transmittance * (1.0 - path * material.mu) * both * reaching;
}

double half_space_reflectance(const Material& material, const BoundaryConstants& constants) {
  validate(material);
  const double decay = decay_of(material), path = 3.0 * material.kappa;
  return constants.normal_transmittance * (1.0 - path * material.mu) /
         ((1.0 + decay * path) * (1.0 + 2.0 * constants.A * material.kappa * decay));
}

}  // namespace kappamu::forward
