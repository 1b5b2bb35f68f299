// Diffuse reflectance under light that varies as cos 2πf x, by transport with Henyey-Greenstein
// scattering: half-space, slab of known thickness, or two layers one of which is known.
//
// A half-space's reflectance is diffusion's in closed form times a tabulated ratio, fitted to white
// Monte Carlo runs (half_space_walk.h; `kappamu-studies sfdi --section table` remakes the table). A
// slab's is the half-space's times diffusion's ratio of the two, glass slides included. Two layers,
// and light that shines through a slab, are by spherical harmonics (layered_transport.h).
#pragma once

#include <memory>
#include <optional>

#include "forward/lateral/lateral_basis.h"

namespace kappamu::forward {

/// Known coefficients of a layer.
struct LateralLayer {
  double mua = 0.0;   ///< μa [1/mm], > 0
  double musp = 0.0;  ///< σs' [1/mm], > 0
};
struct LateralCover : LateralLayer {
  double thickness_mm = 0.0;  ///< > 0
};

/// What a table is made for. Light enters as a beam at normal incidence, all that leaves is seen.
struct LateralMedium {
  double index = 1.4;                       ///< refractive index relative to outside, 1.33 to 1.5
  double anisotropy = 0.9;                  ///< g, 0.7 to 0.95
  std::optional<double> thickness_mm = {};  ///< absent: half-space
  std::optional<double> slide_index = {};   ///< of glass on both sides of a slab; absent: air
  std::optional<LateralCover> cover = {};   ///< known layer over a half-space
  std::optional<LateralLayer> base = {};    ///< known half-space under a layer of thickness_mm
};

struct LateralValue {
  double reflectance = 0.0;  ///< light that leaves over light that entered, dimensionless
  double d_mua = 0.0;        ///< ∂R/∂μa [mm]
  double d_musp = 0.0;       ///< ∂R/∂σs' [mm]
};

class LateralStack;

class LateralReflectance {
 public:
  /// Throws InputError naming the bound unless the medium is one the table holds, and for a cover
  /// beside a thickness.
  explicit LateralReflectance(const LateralMedium& medium);

  /// At spatial frequency f [1/mm] ≥ 0, μa [1/mm] > 0 and σs' [1/mm] > 0, of the layer that is not
  /// known. Outside covers() the
  /// table's edge answers.
  LateralValue operator()(double frequency, double mua, double musp) const;
  /// Light that leaves a slab through its far side over light that entered. Needs a thickness.
  LateralValue transmittance(double frequency, double mua, double musp) const;
  /// Its standard error over T.
  double transmittance_error() const;
  /// Standard error over R: of the Monte Carlo and of the table's fit to it, and for a slab of the
  /// ratio.
  double relative_error(double frequency, double mua, double musp) const;
  /// √(3 μa/σs' + (2πf/σs')²) ≤ 9.
  static bool covers(double frequency, double mua, double musp);

  const LateralMedium& medium() const { return medium_; }

 private:
  LateralValue half_space(double a, double k) const;  ///< derivatives by a and k
  bool layered() const { return medium_.cover || medium_.base; }
  LateralMedium medium_;
  double robin_A_ = 1.0, surface_A_ = 1.0;  ///< of the bare surface; of the slab's own
  LateralCoefficients coefficients_{};
  std::shared_ptr<const LateralStack> stack_;  ///< where there is a thickness or a layer
};

}  // namespace kappamu::forward
