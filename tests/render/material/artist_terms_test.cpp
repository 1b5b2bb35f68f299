// Colour and mean free path in place of κ and μ: they are one another's inverse, the colour is the
// half-space's by diffusion, and what diffusion errs by against transport is as stated.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/optics.h"
#include "forward/lateral/lateral_diffusion.h"
#include "forward/lateral/lateral_reflectance.h"
#include "render/material/homogeneous.h"

namespace kappamu::render {
namespace {

constexpr double rounding = 1e-12;

TEST(ArtistTerms, AreDiffusionsReflectanceOfAHalfSpace) {
  for (const double eta : {1.0, 1.3, 1.5}) {
    const double A = boundary_constants(eta).A;
    for (const double kappa : {0.03, 0.4}) {
      for (const double mu : {0.0, 1e-5, 0.003, 0.2}) {
        const double scattering = 1.0 / (3.0 * kappa) - mu;
        const ArtistTerms terms = artist_terms(kappa, mu, A);
        EXPECT_NEAR(terms.albedo, forward::diffuse_half_space(mu / scattering, 0.0, A), rounding);
        EXPECT_DOUBLE_EQ(terms.mean_free_path_mm, 1.0 / (scattering + mu));
      }
    }
  }
}

TEST(ArtistTerms, AreInverted) {
  const double A = boundary_constants(1.4).A;
  for (const double albedo : {1e-6, 0.01, 0.3, 0.7, 0.99, 0.999999}) {
    for (const double path : {0.01, 3.0}) {
      const DiffusionTerms terms = diffusion_terms({albedo, path}, A);
      const ArtistTerms again = artist_terms(terms.kappa_mm, terms.mu_per_mm, A);
      EXPECT_NEAR(again.albedo, albedo, rounding);
      EXPECT_NEAR(again.mean_free_path_mm, path, rounding * path);
    }
  }
  EXPECT_EQ(diffusion_terms({1.0, 1.0}, A).mu_per_mm, 0.0);
}

/// Against white Monte Carlo's table (forward/lateral/lateral_reflectance.h).
TEST(ArtistTerms, ErrByWhatIsStatedAgainstTransport) {
  struct Bound {
    double albedo, error;
  };
  for (const double eta : {1.33, 1.5}) {
    const double A = boundary_constants(eta).A;
    for (const double anisotropy : {0.8, 0.9}) {
      const forward::LateralReflectance transport({eta, anisotropy, {}});
      for (const Bound& bound : {Bound{0.9, 0.01}, Bound{0.7, 0.012}, Bound{0.5, 0.05},
                                 Bound{0.3, 0.15}, Bound{0.2, 0.3}}) {
        const DiffusionTerms terms = diffusion_terms({bound.albedo, 1.0}, A);
        const double scattering = 1.0 / (3.0 * terms.kappa_mm) - terms.mu_per_mm;
        const double of_transport = transport(0.0, terms.mu_per_mm, scattering).reflectance;
        const double error = bound.albedo / of_transport - 1.0;
        std::printf("eta %.2f, g %.1f, albedo %.1f: diffusion exceeds transport by %.1f %%\n", eta,
                    anisotropy, bound.albedo, 100.0 * error);
        EXPECT_GT(error, -0.001);
        EXPECT_LT(error, bound.error) << eta << " " << bound.albedo;
      }
    }
  }
}

}  // namespace
}  // namespace kappamu::render
