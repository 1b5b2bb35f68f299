#include "render/material/subsurface.h"

#include <algorithm>
#include <cmath>

namespace kappamu::render {

namespace {

using Convention = Subsurface::Convention;

/// s = a + b C − √(c + d C + e C²).
struct Inversion {
  static constexpr double a = 4.09712, b = 4.20863, c = 9.59217, d = 41.6808, e = 17.7126;
};

double openpbr_albedo(double colour, double g) {
  using In = Inversion;
  const double s =
      In::a + In::b * colour - std::sqrt(In::c + In::d * colour + In::e * colour * colour);
  return (1.0 - s * s) / (1.0 - g * s * s);
}

/// The root of (a + b C − s)² = c + d C + e C² in [0, 1], without cancellation where b² ≈ e.
double openpbr_colour(double albedo) {
  using In = Inversion;
  const double rest = In::a - std::sqrt(std::max(0.0, 1.0 - albedo));
  const double square = In::b * In::b - In::e, linear = 2.0 * In::b * rest - In::d,
               constant = rest * rest - In::c;
  const double root = std::sqrt(std::max(0.0, linear * linear - 4.0 * square * constant));
  return std::clamp(2.0 * constant / (-linear + root), 0.0, 1.0);
}

double principled_albedo(double colour) {
  return 1.0 - std::exp(colour * (-5.09406 + colour * (2.61188 - colour * 4.31805)));
}

double principled_colour(double albedo) {
  double low = 0.0, high = 1.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (principled_albedo(middle) < albedo ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double principled_scale(double colour) {
  return 1.9 - colour + 3.5 * (colour - 0.8) * (colour - 0.8);
}

}  // namespace

HomogeneousMaterial material_of(const Subsurface& subsurface) {
  const bool principled = subsurface.convention == Convention::principled;
  const double g = principled ? 0.0 : subsurface.anisotropy;
  Colour scattering, absorption;
  for (int k = 0; k < 3; ++k) {
    const double colour = subsurface.colour[k];
    const double albedo = principled ? principled_albedo(colour) : openpbr_albedo(colour, g);
    const double scale = principled ? principled_scale(colour) : 1.0;
    const double extinction = 1.0 / (subsurface.radius_mm[k] * scale);
    scattering[k] = std::max(1e-6, (1.0 - g) * albedo * extinction);
    absorption[k] = std::max(0.0, (1.0 - albedo) * extinction);
  }
  HomogeneousMaterial material = homogeneous_material(scattering, absorption);
  material.source = "subsurface colour and radius (" +
                    std::string(name_of(convention_names, subsurface.convention)) + ")";
  return material;
}

Subsurface subsurface_of(const HomogeneousMaterial& material, Convention convention) {
  Subsurface result;
  result.convention = convention;
  for (int k = 0; k < 3; ++k) {
    const double path = 3.0 * material.kappa_mm[k];  // 1/(σs' + μ)
    const double albedo = std::clamp(1.0 - path * material.mu_per_mm[k], 0.0, 1.0);
    const bool principled = convention == Convention::principled;
    result.colour[k] = principled ? principled_colour(albedo) : openpbr_colour(albedo);
    result.radius_mm[k] = principled ? path / principled_scale(result.colour[k]) : path;
  }
  return result;
}

}  // namespace kappamu::render
