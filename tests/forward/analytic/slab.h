// Diffusion in a laterally infinite slab under even light, in closed form: an oracle for the grid
// solvers (mirror sides make a block such a slab), and the exitance of a homogeneous slab for free.
//
// Between z = 0 (lit) and z = L:  κ φ'' − μ φ + S e^(−z/l) + S_b e^((z−L)/l) = 0, with φ − 2Aκ φ' =
// q at z = 0 and φ + 2Aκ φ' = 0 at z = L. S = σs' E_t D and l = 3κ for the first-collision source,
// S_b = R e^(−L/l) S for what comes back from z = L, with D = 1/(1 − R² e^(−2L/l)) for what comes
// back again; S = S_b = 0 and q = 4E_t/(1−R_φ) for the boundary source.
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "core/error.h"
#include "core/optics.h"

namespace kappamu::forward {

struct Slab {
  double kappa = 0.0;      ///< κ [mm], > 0
  double mu = 0.0;         ///< μ [1/mm], > 0 and 9 κ μ ≠ 1
  double thickness = 0.0;  ///< L [mm]
};

/// φ(z) and what follows from it; linear in the irradiance.
class SlabFluence {
 public:
  /// Volume sources S and S_b [irradiance/mm] decaying over l = 3κ from z = 0 and from z = L, and
  /// boundary term `q`.
  SlabFluence(const Slab& slab, double robin_A, double S, double S_b, double q);

  double operator()(double z) const;
  double derivative(double z) const;
  /// Mean of φ over a ≤ z ≤ b, exact: what a finite volume holds.
  double mean(double a, double b) const;
  /// Flux leaving at z = L, −κφ'(L).
  double exitance_far() const;
  /// Flux leaving at z = 0, κφ'(0); negative where more enters than leaves.
  double exitance_near() const;

 private:
  double kappa_, decay_, beam_decay_, thickness_;
  // φ = rising_ e^(d (z−L)) + falling_ e^(−d z) + away_ e^(−z/l) + back_ e^((z−L)/l), d = √(μ/κ)
  double rising_ = 0.0, falling_ = 0.0, away_ = 0.0, back_ = 0.0;
};

/// Under the first-collision source of irradiance E (before Fresnel).
SlabFluence slab_first_collision(const Slab& slab, const BoundaryConstants& constants, double E);

/// Under the boundary source of irradiance E (before Fresnel).
SlabFluence slab_boundary(const Slab& slab, const BoundaryConstants& constants, double E);

inline SlabFluence::SlabFluence(const Slab& slab, double robin_A, double S, double S_b, double q)
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
  away_ = -S / resonance;
  back_ = -S_b / resonance;

  // The two Robin conditions; both exponentials are at most 1, so nothing overflows.
  const double b = 2.0 * robin_A * kappa_;
  const double across = std::exp(-decay_ * thickness_);
  const double passes = std::exp(-beam_decay_ * thickness_);
  const double with = 1.0 + b * beam_decay_, against = 1.0 - b * beam_decay_;
  Eigen::Matrix2d m;
  m << across * (1.0 - b * decay_), 1.0 + b * decay_,  //
      1.0 + b * decay_, across * (1.0 - b * decay_);
  const Eigen::Vector2d right(q - away_ * with - back_ * passes * against,
                              -away_ * passes * against - back_ * with);
  const Eigen::Vector2d solution = m.partialPivLu().solve(right);
  rising_ = solution[0];
  falling_ = solution[1];
}

inline double SlabFluence::operator()(double z) const {
  return rising_ * std::exp(decay_ * (z - thickness_)) + falling_ * std::exp(-decay_ * z) +
         away_ * std::exp(-beam_decay_ * z) + back_ * std::exp(beam_decay_ * (z - thickness_));
}

inline double SlabFluence::derivative(double z) const {
  return decay_ *
             (rising_ * std::exp(decay_ * (z - thickness_)) - falling_ * std::exp(-decay_ * z)) +
         beam_decay_ * (back_ * std::exp(beam_decay_ * (z - thickness_)) -
                        away_ * std::exp(-beam_decay_ * z));
}

inline double SlabFluence::mean(double a, double b) const {
  const auto antiderivative = [&](double z) {
    return (rising_ * std::exp(decay_ * (z - thickness_)) - falling_ * std::exp(-decay_ * z)) /
               decay_ +
           (back_ * std::exp(beam_decay_ * (z - thickness_)) - away_ * std::exp(-beam_decay_ * z)) /
               beam_decay_;
  };
  return (antiderivative(b) - antiderivative(a)) / (b - a);
}

inline double SlabFluence::exitance_far() const {
  return -kappa_ * derivative(thickness_);
}
inline double SlabFluence::exitance_near() const {
  return kappa_ * derivative(0.0);
}

inline SlabFluence slab_first_collision(const Slab& slab, const BoundaryConstants& constants,
                                        double E) {
  const double extinction = 1.0 / (3.0 * slab.kappa);
  const double comes_back =
      (1.0 - constants.normal_transmittance) * std::exp(-extinction * slab.thickness);
  const double S =
      (extinction - slab.mu) * constants.normal_transmittance * E / (1.0 - comes_back * comes_back);
  return {slab, constants.A, S, comes_back * S, 0.0};
}

inline SlabFluence slab_boundary(const Slab& slab, const BoundaryConstants& constants, double E) {
  return {slab, constants.A, 0.0, 0.0,
          constants.normal_transmittance * E * constants.q_per_entering()};
}

}  // namespace kappamu::forward
