#include "forward/analytic/slab.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/error.h"

namespace kappamu::forward {

SlabFluence::SlabFluence(const Slab& slab, double robin_A, double volume_source, double q)
    : kappa_(slab.kappa),
      decay_(std::sqrt(slab.mu / slab.kappa)),
      beam_decay_(1.0 / (3.0 * slab.kappa)),
      thickness_(slab.thickness) {
  if (!(slab.kappa > 0.0 && slab.mu > 0.0 && slab.thickness > 0.0)) {
    throw InputError("slab: kappa, mu and thickness must be positive");
  }
  const double resonance = kappa_ * beam_decay_ * beam_decay_ - slab.mu;
  if (std::abs(resonance) < 1e-9 * slab.mu) {
    throw InputError("slab: 9 kappa mu = 1 makes the closed form singular; change mu slightly");
  }
  particular_ = -volume_source / resonance;

  // The two Robin conditions; both exponentials are at most 1, so nothing overflows.
  const double b = 2.0 * robin_A * kappa_;
  const double across = std::exp(-decay_ * thickness_);
  const double beam_far = particular_ * std::exp(-beam_decay_ * thickness_);
  Eigen::Matrix2d m;
  m << across * (1.0 - b * decay_), 1.0 + b * decay_,  //
      1.0 + b * decay_, across * (1.0 - b * decay_);
  const Eigen::Vector2d right(q - particular_ * (1.0 + b * beam_decay_),
                              -beam_far * (1.0 - b * beam_decay_));
  const Eigen::Vector2d solution = m.partialPivLu().solve(right);
  rising_ = solution[0];
  falling_ = solution[1];
}

double SlabFluence::operator()(double z) const {
  return rising_ * std::exp(decay_ * (z - thickness_)) + falling_ * std::exp(-decay_ * z) +
         particular_ * std::exp(-beam_decay_ * z);
}

double SlabFluence::derivative(double z) const {
  return decay_ *
             (rising_ * std::exp(decay_ * (z - thickness_)) - falling_ * std::exp(-decay_ * z)) -
         beam_decay_ * particular_ * std::exp(-beam_decay_ * z);
}

double SlabFluence::mean(double a, double b) const {
  const auto antiderivative = [&](double z) {
    return (rising_ * std::exp(decay_ * (z - thickness_)) - falling_ * std::exp(-decay_ * z)) /
               decay_ -
           particular_ * std::exp(-beam_decay_ * z) / beam_decay_;
  };
  return (antiderivative(b) - antiderivative(a)) / (b - a);
}

double SlabFluence::exitance_far() const {
  return -kappa_ * derivative(thickness_);
}
double SlabFluence::exitance_near() const {
  return kappa_ * derivative(0.0);
}

SlabFluence slab_first_collision(const Slab& slab, const BoundaryConstants& constants, double E) {
  const double scattering = 1.0 / (3.0 * slab.kappa) - slab.mu;
  return {slab, constants.A, scattering * constants.normal_transmittance * E, 0.0};
}

SlabFluence slab_boundary(const Slab& slab, const BoundaryConstants& constants, double E) {
  return {slab, constants.A, 0.0, constants.normal_transmittance * E * constants.q_per_entering()};
}

}  // namespace kappamu::forward
