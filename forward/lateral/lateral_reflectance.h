// Diffuse reflectance under light that varies as cos 2πf x, by transport with Henyey-Greenstein
// scattering: half-space, or slab of known thickness.
//
// A half-space's reflectance is diffusion's in closed form times a tabulated ratio, fitted to white
// Monte Carlo runs (half_space_walk.h; `kappamu-studies sfdi table` remakes the table). A slab's is
// the half-space's times diffusion's ratio of the two.
#pragma once

#include <optional>

#include "forward/lateral/lateral_basis.h"

namespace kappamu::forward {

/// What a table is made for. Light enters as a beam at normal incidence, all that leaves is seen.
struct LateralMedium {
  double index = 1.4;                       ///< refractive index relative to outside, 1.33 to 1.5
  double anisotropy = 0.9;                  ///< g, 0.7 to 0.95
  std::optional<double> thickness_mm = {};  ///< absent: half-space
};

struct LateralValue {
  double reflectance = 0.0;  ///< light that leaves over light that entered, dimensionless
  double d_mua = 0.0;        ///< ∂R/∂μa [mm]
  double d_musp = 0.0;       ///< ∂R/∂σs' [mm]
};

class LateralReflectance {
 public:
  /// Throws InputError naming the bound unless the medium is one the table holds.
  explicit LateralReflectance(const LateralMedium& medium);

  /// At spatial frequency f [1/mm] ≥ 0, μa [1/mm] > 0 and σs' [1/mm] > 0. Outside covers() the
  /// table's edge answers.
  LateralValue operator()(double frequency, double mua, double musp) const;
  /// Standard error over R: of the Monte Carlo and of the table's fit to it, and for a slab of the
  /// ratio.
  double relative_error(double frequency, double mua, double musp) const;
  /// √(3 μa/σs' + (2πf/σs')²) ≤ 9.
  static bool covers(double frequency, double mua, double musp);

  const LateralMedium& medium() const { return medium_; }

 private:
  LateralValue half_space(double a, double k) const;  ///< derivatives by a and k

  LateralMedium medium_;
  double robin_A_ = 1.0;
  LateralCoefficients coefficients_{};
};

}  // namespace kappamu::forward
