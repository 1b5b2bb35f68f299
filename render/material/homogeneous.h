// Coefficients that are the same everywhere in an object.
#pragma once

#include <optional>
#include <string>

#include "render/colour.h"

namespace kappamu::render {

/// The same coefficients everywhere, one per channel.
struct HomogeneousMaterial {
  Colour kappa_mm = Colour::Ones();
  Colour mu_per_mm = Colour::Zero();
  std::optional<double> eta;  ///< relative refractive index, where published
  std::string source;         ///< where the numbers come from
};

/// κ = 1/(3(σa + σs')), μ = σa.
inline HomogeneousMaterial homogeneous_material(const Colour& reduced_scattering_per_mm,
                                                const Colour& absorption_per_mm) {
  HomogeneousMaterial material;
  material.kappa_mm = 1.0 / (3.0 * (reduced_scattering_per_mm + absorption_per_mm));
  material.mu_per_mm = absorption_per_mm;
  return material;
}

}  // namespace kappamu::render
