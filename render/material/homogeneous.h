// The same coefficients everywhere in an object, and what an artist says in their place.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "render/colour.h"

namespace kappamu::render {

/// One pair of coefficients per channel.
struct HomogeneousMaterial {
  Colour kappa_mm = Colour::Ones();
  Colour mu_per_mm = Colour::Zero();
  std::optional<double> eta;  ///< relative refractive index, where published
  std::string source;         ///< where the numbers come from
  std::optional<std::filesystem::path> file = std::nullopt;  ///< that they were read from
};

/// κ = 1/(3(σa + σs')), μ = σa.
HomogeneousMaterial homogeneous_material(const Colour& reduced_scattering_per_mm,
                                         const Colour& absorption_per_mm);

/// Colour and mean free path of one channel, in place of κ and μ. With q = 3√(κμ) and A of the
/// boundary condition (core/optics.h), a half-space under a beam at normal incidence returns, of
/// the light that enters it,
///
///     R = (1 − q²/3) / ((1 + q)(1 + 2Aq/3))
///
/// by diffusion of its first collisions (forward/lateral/lateral_diffusion.h at k = 0). R is solved
/// for q in closed form. Diffusion's R exceeds transport's by up to 1.2 % at R = 0.7, 5 % at 0.5,
/// 15 % at 0.3 and 30 % at 0.2 (η 1.33 to 1.5, g 0.8 and 0.9; measured by
/// tests/render/material/artist_terms_test.cpp).
struct ArtistTerms {
  double albedo = 0.5;             ///< R, in (0, 1]; 1 without absorption
  double mean_free_path_mm = 1.0;  ///< 1/σt' = 3κ
};
ArtistTerms artist_terms(double kappa_mm, double mu_per_mm, double robin_A);

struct DiffusionTerms {
  double kappa_mm = 1.0, mu_per_mm = 0.0;
};
/// The inverse.
DiffusionTerms diffusion_terms(const ArtistTerms& terms, double robin_A);

}  // namespace kappamu::render
