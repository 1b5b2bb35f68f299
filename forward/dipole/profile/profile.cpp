#include "forward/dipole/profile/profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu::forward::dipole {

namespace {

constexpr double four_pi = 4.0 * std::numbers::pi;

struct Extinction {
  double total = 0.0;   ///< σt' [1/mm]
  double albedo = 0.0;  ///< α'
};

Extinction extinction_of(const Material& m) {
  if (!(m.kappa > 0.0 && std::isfinite(m.kappa) && m.mu >= 0.0 && 3.0 * m.kappa * m.mu < 1.0)) {
    throw InputError("the dipole needs kappa > 0 and mu in 0 <= mu < 1/(3 kappa), but kappa is " +
                     std::to_string(m.kappa) + " and mu " + std::to_string(m.mu));
  }
  return {1.0 / (3.0 * m.kappa), 1.0 - 3.0 * m.kappa * m.mu};
}

/// e^(−σs)/s and what −(1/s) d/ds makes of it, once, twice and three times.
struct Radial {
  double t0, t1, t2, t3;
};

Radial radial(double decay, double s) {
  const double q = decay * s, i = 1.0 / s, i2 = i * i, e = std::exp(-q) * i;
  return {e, e * i2 * (1.0 + q), e * i2 * i2 * (3.0 + q * (3.0 + q)),
          e * i2 * i2 * i2 * (15.0 + q * (15.0 + q * (6.0 + q)))};
}

/// Grosjean's medium and what of fluence and flux leaves.
struct BetterDipole {
  Extinction extinction;
  double D = 0.0, extrapolation = 0.0, decay = 0.0;  ///< [mm], [mm], [1/mm]
  double of_fluence = 0.0, of_flux = 0.0;            ///< C_φ, C_E

  BetterDipole(const Material& m, const BoundaryConstants& c) : extinction(extinction_of(m)) {
    const double sigma = extinction.total;
    D = (sigma + m.mu) / (3.0 * sigma * sigma);
    extrapolation = 2.0 * c.A * D;
    decay = std::sqrt(m.mu / D);
    of_fluence = 0.25 * (1.0 - c.r_phi);
    of_flux = 0.5 * (1.0 - c.r_j);
  }

  /// A source of unit power at `depth` and its image.
  void add(double depth, double power, std::vector<SourceTerm>& terms) const {
    const double strength = power * extinction.albedo * extinction.albedo / four_pi;
    for (const double side : {1.0, -1.0}) {
      const double z = side > 0.0 ? depth : depth + 2.0 * extrapolation;
      terms.push_back({z, side * strength * of_fluence / D, strength * of_flux * z, side});
    }
  }
};

}  // namespace

Profile::Profile(double decay, std::vector<SourceTerm> terms)
    : decay_(decay), terms_(std::move(terms)) {
  check(!terms_.empty() && decay >= 0.0, "a profile has terms and a decay that is not negative");
}

RadialDerivatives Profile::derivatives(double r) const {
  RadialDerivatives sum;
  for (const SourceTerm& t : terms_) {
    const Radial k = radial(decay_, std::hypot(r, t.z));
    sum.value += t.fluence * k.t0 + t.flux * k.t1;
    sum.first -= t.fluence * k.t1 + t.flux * k.t2;
    sum.second += t.fluence * k.t2 + t.flux * k.t3;
  }
  return sum;
}

double Profile::aligned_value(const Eigen::Vector3d& from, const Eigen::Vector3d& normal,
                              const Eigen::Vector3d& to) const {
  double sum = 0.0;
  for (const SourceTerm& t : terms_) {
    const Radial k = radial(decay_, (to - from + t.side * t.z * normal).norm());
    sum += t.fluence * k.t0 + t.flux * k.t1;
  }
  return sum;
}

double Profile::term_beyond(const SourceTerm& term, double s) const {
  // ∫ e^(−σs) ds less its own value at s = 0: finite where σ = 0, and all such add to nothing.
  const double fluence =
      term.fluence == 0.0 ? 0.0 : (decay_ > 0.0 ? std::expm1(-decay_ * s) / decay_ : -s);
  return term.fluence * fluence + term.flux * std::exp(-decay_ * s) / s;
}

double Profile::beyond(double r) const {
  double sum = 0.0;
  for (const SourceTerm& t : terms_) sum += term_beyond(t, std::hypot(r, t.z));
  return sum;
}

double Profile::reflectance() const {
  return 2.0 * std::numbers::pi * beyond(0.0);
}

double Profile::smallest_depth() const {
  return std::min_element(terms_.begin(), terms_.end(),
                          [](const SourceTerm& a, const SourceTerm& b) { return a.z < b.z; })
      ->z;
}

Profile classical_dipole(const Material& material, double A) {
  const Extinction extinction = extinction_of(material);
  const double real = 1.0 / extinction.total, image = real + 4.0 * A * material.kappa;
  const double strength = extinction.albedo / four_pi;
  return {std::sqrt(material.mu / material.kappa),
          {{real, 0.0, strength * real, 1.0}, {image, 0.0, strength * image, -1.0}}};
}

Profile better_dipole(const Material& material, const BoundaryConstants& constants) {
  const BetterDipole better(material, constants);
  std::vector<SourceTerm> terms;
  better.add(1.0 / better.extinction.total, 1.0, terms);
  return {better.decay, std::move(terms)};
}

Profile beam_diffusion(const Material& material, const BoundaryConstants& constants) {
  // The trapezoidal rule in ln(σt' z), whose integrand falls off on either side.
  constexpr double shallowest = -7.0, deepest = 3.5, step = 0.25;
  const BetterDipole better(material, constants);
  std::vector<double> depth, weight;
  double sum = 0.0;
  for (double y = shallowest; y <= deepest; y += step) {
    const double x = std::exp(y);
    depth.push_back(x / better.extinction.total);
    weight.push_back(std::exp(-x) * x);
    sum += weight.back();
  }
  std::vector<SourceTerm> terms;
  for (std::size_t i = 0; i < depth.size(); ++i) better.add(depth[i], weight[i] / sum, terms);
  return {better.decay, std::move(terms)};
}

Profile make_profile(std::string_view name, const Material& material, double eta) {
  const BoundaryConstants constants = boundary_constants(eta);
  if (name == "dipole") return classical_dipole(material, constants.A);
  if (name == "better-dipole") return better_dipole(material, constants);
  if (name == "beam-diffusion") return beam_diffusion(material, constants);
  throw InputError("there is no profile '" + std::string(name) +
                   "'; write dipole, better-dipole or beam-diffusion");
}

}  // namespace kappamu::forward::dipole
