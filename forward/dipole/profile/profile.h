// BSSRDF profiles of homogeneous media: exitance at a point of a surface per unit of power that was
// refracted in at another one. Each is a sum over point sources below the surface of a half-space
// and their images above it, so that value, derivatives and integrals over the plane are closed
// forms; on curved surfaces the same sum is used with the distance of the two points ([T] 3.1.3).
//
// κ [mm] and μ [1/mm] as everywhere, σt' = 1/(3κ), α' = 1 − 3κμ; lengths in mm.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/optics.h"

namespace kappamu::forward {

struct Material {
  double kappa = 0.0;  ///< κ [mm], > 0
  double mu = 0.0;     ///< μ [1/mm], >= 0, < 1/(3κ)
};

namespace dipole {

/// One source at height or depth z: adds a·e^(−σs)/s + b·(1 + σs)e^(−σs)/s³, s² = r² + z².
struct SourceTerm {
  double z = 0.0;        ///< [mm], > 0
  double fluence = 0.0;  ///< a [1/mm]
  double flux = 0.0;     ///< b [mm]
  double side = 1.0;     ///< 1: below the surface, −1: image above it
};

/// R_d(r) and its radial derivatives R'/r and (R'/r)'/r: what Taylor series in x_o − x_i need.
struct RadialDerivatives {
  double value = 0.0;   ///< [1/mm²]
  double first = 0.0;   ///< [1/mm⁴]
  double second = 0.0;  ///< [1/mm⁶]
};

class Profile {
 public:
  /// The `fluence` of all terms must sum to 0: a source and its image take as much as they give.
  Profile(double decay, std::vector<SourceTerm> terms);

  /// R_d at distance r >= 0 with the sources' axis turned perpendicular to x_o − x_i: the same for
  /// both points' exchange ([T] 3.4) [1/mm²].
  double value(double r) const { return derivatives(r).value; }
  RadialDerivatives derivatives(double r) const;
  /// The same with the axis along the normal at the entering point: not reciprocal where the
  /// surface bends. `from` and `to` [mm].
  double aligned_value(const Eigen::Vector3d& from, const Eigen::Vector3d& normal,
                       const Eigen::Vector3d& to) const;
  /// ∫ of R_d r' dr' from r to infinity, up to a constant that is the same for all r and vanishes
  /// with them: differences are what it is for, and beyond(0) − beyond(∞) = reflectance/2π.
  double beyond(double r) const;
  /// The share of one term, by the distance s from its source.
  double term_beyond(const SourceTerm& term, double s) const;
  /// 2π ∫ R_d r dr, total diffuse reflectance of the half-space [T] 3.24 (dimensionless).
  double reflectance() const;

  double decay() const { return decay_; }  ///< σ_tr [1/mm]
  double smallest_depth() const;           ///< R_d is smooth below this distance [mm]
  std::span<const SourceTerm> terms() const { return terms_; }

 private:
  double decay_ = 0.0;
  std::vector<SourceTerm> terms_;
};

/// One source at depth z_r = 1/σt', image at z_r + 4Aκ, exitance by Fick's law ([T] Table 3.1).
/// [T] takes A = (1 + F_dr)/(1 − F_dr) with the polynomial F_dr; boundary_constants has the exact
/// one.
Profile classical_dipole(const Material& material, double A);
/// The same two sources with Grosjean's D = (σt' + μ)/(3σt'²) and exitance from fluence and flux,
/// C_φ φ + C_E E (E. d'Eon, A better dipole, 2012). Light scattered more than once: single
/// scattering is apart, where the classical dipole stands for all.
Profile better_dipole(const Material& material, const BoundaryConstants& constants);
/// The better dipole spread over the first collisions of a beam along the normal, e^(−σt' z)σt' dz
/// (R. Habel et al., Photon beam diffusion, EGSR 2013, without their empirical factor near the
/// beam); smooth below a thousandth of the mean free path.
Profile beam_diffusion(const Material& material, const BoundaryConstants& constants);

/// "dipole", "better-dipole" or "beam-diffusion", all with exact Fresnel moments. Throws InputError
/// for another name, or a medium with kappa <= 0 or mu outside [0, 1/(3 kappa)).
Profile make_profile(std::string_view name, const Material& material, double eta);

}  // namespace dipole
}  // namespace kappamu::forward
