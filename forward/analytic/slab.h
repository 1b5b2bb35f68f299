// Diffusion in a laterally infinite slab under even light, in closed form: an oracle for the grid
// solvers (mirror sides make a block such a slab), and the exitance of a homogeneous slab for free.
//
// Between z = 0 (lit) and z = L:  κ φ'' − μ φ + S e^(−z/l) = 0, with φ − 2Aκ φ' = q at z = 0 and
// φ + 2Aκ φ' = 0 at z = L. S = σs' E_t and l = 3κ for the first-collision source, S = 0 and
// q = 4E_t/(1−R_φ) for the boundary source.
#pragma once

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
  /// `volume_source` S [irradiance/mm] decaying as e^(−z/l) with l = 3κ, and boundary term `q`.
  SlabFluence(const Slab& slab, double robin_A, double volume_source, double q);

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
  // φ = rising_ e^(d (z−L)) + falling_ e^(−d z) + particular_ e^(−z/l), d = √(μ/κ)
  double rising_ = 0.0, falling_ = 0.0, particular_ = 0.0;
};

/// Under the first-collision source of irradiance E (before Fresnel).
SlabFluence slab_first_collision(const Slab& slab, const BoundaryConstants& constants, double E);

/// Under the boundary source of irradiance E (before Fresnel).
SlabFluence slab_boundary(const Slab& slab, const BoundaryConstants& constants, double E);

}  // namespace kappamu::forward
