#include "render/material/homogeneous.h"

#include <algorithm>
#include <cmath>

namespace kappamu::render {

HomogeneousMaterial homogeneous_material(const Colour& reduced_scattering_per_mm,
                                         const Colour& absorption_per_mm) {
  HomogeneousMaterial material;
  material.kappa_mm = 1.0 / (3.0 * (reduced_scattering_per_mm + absorption_per_mm));
  material.mu_per_mm = absorption_per_mm;
  return material;
}

ArtistTerms artist_terms(double kappa_mm, double mu_per_mm, double robin_A) {
  const double q = 3.0 * std::sqrt(kappa_mm * mu_per_mm);
  const double albedo = (1.0 - q * q / 3.0) / ((1.0 + q) * (1.0 + 2.0 * robin_A * q / 3.0));
  return {std::max(albedo, 0.0), 3.0 * kappa_mm};
}

DiffusionTerms diffusion_terms(const ArtistTerms& terms, double robin_A) {
  // (1/3 + R c) q² + R (1 + c) q − (1 − R) = 0 with c = 2A/3; its positive root without
  // cancellation.
  const double R = terms.albedo, c = 2.0 * robin_A / 3.0;
  const double a = 1.0 / 3.0 + R * c, b = R * (1.0 + c), rest = 1.0 - R;
  const double q = 2.0 * rest / (b + std::sqrt(b * b + 4.0 * a * rest));
  const double kappa = terms.mean_free_path_mm / 3.0;
  return {kappa, q * q / (9.0 * kappa)};
}

}  // namespace kappamu::render
