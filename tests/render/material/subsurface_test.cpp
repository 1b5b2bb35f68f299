// Conversions of shader parameters against random walks in a half-space, and back.
#include "render/material/subsurface.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "forward/lateral/half_space_walk.h"
#include "render/material/published_materials.h"

namespace kappamu::render {
namespace {

using Convention = Subsurface::Convention;

constexpr double nothing_reflected = 1.0;

/// Reflectance of a half-space without a reflecting boundary: [0] of an even beam, then at the
/// spatial frequencies `per_mm` (2πf).
forward::WhiteReflectance walked(const HomogeneousMaterial& material,
                                 const std::vector<double>& per_mm) {
  const double absorption = material.mu_per_mm[0],
               scattering = 1.0 / (3.0 * material.kappa_mm[0]) - absorption;
  std::vector<forward::LateralPoint> points{{absorption / scattering, 0.0}};
  for (const double k : per_mm) points.push_back({absorption / scattering, k / scattering});
  forward::WalkOptions options;
  options.anisotropy = 0.0;
  options.indices = {nothing_reflected};
  options.photons = 1 << 16;
  options.seed = 17;
  return forward::walk_half_space(options, points);
}

TEST(Subsurface, RoundTripsThroughCoefficients) {
  for (const Convention convention : {Convention::openpbr, Convention::principled}) {
    for (const double colour : {0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
      for (const double radius : {0.05, 1.0, 20.0}) {
        Subsurface given;
        given.convention = convention;
        given.colour = Colour(colour, 0.5 * colour, 0.9 * colour);
        given.radius_mm = Colour(radius, 2.0 * radius, 0.5 * radius);
        const Subsurface back = subsurface_of(material_of(given), convention);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(back.colour[c], given.colour[c], 1e-5);
          EXPECT_NEAR(back.radius_mm[c] / given.radius_mm[c], 1.0, 1e-4);
        }
      }
    }
  }
}

TEST(Subsurface, RoundTripsPublishedMaterials) {
  for (const std::string& name : published_material_names()) {
    const HomogeneousMaterial material = published_material(name);
    for (const Convention convention : {Convention::openpbr, Convention::principled}) {
      const HomogeneousMaterial back = material_of(subsurface_of(material, convention));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(back.kappa_mm[c] / material.kappa_mm[c], 1.0, 1e-4) << name;
        const double albedo = 1.0 - 3.0 * material.kappa_mm[c] * material.mu_per_mm[c];
        // Whiter media than colour 1 stands for keep their extinction alone.
        if (convention == Convention::principled && albedo > 0.9988) continue;
        EXPECT_NEAR(3.0 * back.kappa_mm[c] * back.mu_per_mm[c], 1.0 - albedo, 2e-5) << name;
      }
    }
  }
}

/// Anisotropy changes a medium to its similar one: the same colour up to what similarity keeps.
TEST(Subsurface, AnisotropyKeepsTheColour) {
  Subsurface given;
  given.colour.setConstant(0.6);
  const double plain = walked(material_of(given), {}).value[0];
  given.anisotropy = 0.7;
  EXPECT_NEAR(walked(material_of(given), {}).value[0], plain, 0.02);
}

/// Exact reflectances of a half-space of isotropic scatterers, by Chandrasekhar's H function
/// (Radiative Transfer, 1950, § 38): 1/H(m) = √(1 − α) + (α/2) ∫ m' H(m')/(m + m') dm'.
struct HalfSpace {
  explicit HalfSpace(double albedo) : root(std::sqrt(1.0 - albedo)), half(0.5 * albedo) {
    for (int round = 0; round < 2000; ++round) {
      std::array<double, nodes> next{};
      for (std::size_t i = 0; i < nodes; ++i) next[i] = h_at(cosine(i));
      h = next;
    }
  }
  double of_normal_beam() const { return 1.0 - root * h_at(1.0); }
  /// Of light that is even from all directions, whose share that leaves is the shader's colour.
  double of_diffuse_light() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < nodes; ++i) sum += h[i] * cosine(i) / nodes;
    return 1.0 - 2.0 * root * sum;
  }

 private:
  static constexpr std::size_t nodes = 100;
  static double cosine(std::size_t i) { return (static_cast<double>(i) + 0.5) / nodes; }
  double h_at(double m) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < nodes; ++i) sum += cosine(i) * h[i] / (m + cosine(i)) / nodes;
    return 1.0 / (root + half * sum);
  }
  double root, half;
  std::array<double, nodes> h = [] {
    std::array<double, nodes> ones{};
    ones.fill(1.0);
    return ones;
  }();
};

/// Errors over albedo and radius (docs/scene.md states them): of the colour in diffuse light,
/// exactly; under a normal beam, random walks give what the H function gives. A half-space has no
/// length of its own, so that radii matter by the width of the light alone: reflectance at the
/// frequencies 2πf = 1/(3d) and 1/d against that of the normalised profile
/// R(k) = C/4 (1/√(1 + k²d²) + 3/√(1 + 9k²d²)).
TEST(Subsurface, ColoursAreThoseOfHalfSpaces) {
  std::printf("convention  colour  diffuse  normal  profile at 1/(3d), 1/d\n");
  for (const Convention convention : {Convention::openpbr, Convention::principled}) {
    const bool principled = convention == Convention::principled;
    for (const double colour : {0.1, 0.3, 0.5, 0.7, 0.9, 0.97}) {
      Subsurface given;
      given.convention = convention;
      given.colour.setConstant(colour);
      given.radius_mm.setConstant(2.0);
      const double d = given.radius_mm[0];
      const HomogeneousMaterial material = material_of(given);
      const HalfSpace exact(1.0 - 3.0 * material.kappa_mm[0] * material.mu_per_mm[0]);
      const forward::WhiteReflectance made = walked(material, {1.0 / (3.0 * d), 1.0 / d});
      const auto profile = [&](double kd) {
        return 0.25 * (1.0 / std::sqrt(1.0 + kd * kd) + 3.0 / std::sqrt(1.0 + 9.0 * kd * kd));
      };
      const double error = exact.of_diffuse_light() - colour;
      const double low = made.value[1] / made.value[0] / profile(1.0 / 3.0) - 1.0,
                   high = made.value[2] / made.value[0] / profile(1.0) - 1.0;
      std::printf("%-10s  %.2f    %+.4f  %+.4f %+.3f %+.3f\n",
                  std::string(name_of(convention_names, convention)).c_str(), colour, error,
                  made.value[0] - colour, low, high);
      constexpr double quadrature = 5e-4;
      EXPECT_NEAR(made.value[0], exact.of_normal_beam(), 4.0 * made.standard_error[0] + quadrature);
      EXPECT_LT(std::abs(error), principled && colour > 0.8 ? 0.07 : 0.006) << colour;
      if (principled) {
        EXPECT_LT(std::abs(low), 0.15) << colour;
        EXPECT_LT(std::abs(high), 0.20) << colour;
      }
    }
  }
}

}  // namespace
}  // namespace kappamu::render
