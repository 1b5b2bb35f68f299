#include "forward/lateral/lateral_diffusion.h"

#include <array>
#include <cmath>

#include "forward/analytic/layered_mode.h"

namespace kappamu::forward {

double diffuse_half_space(double a, double k, double robin_A) {
  // κφ'' − (a + κk²)φ + e^(−τz) = 0 with τ = 1 + a, κ = 1/(3τ): decay γ² = 3aτ + k². The particular
  // solution −3τ/(τ² − γ²) e^(−τz) is singular at γ = τ; the flux out is not:
  // φ(0)/(2A) = 1/(1 + 2Aκγ) · ∫ e^(−τz) e^(−γz) dz.
  const double tau = 1.0 + a;
  const double decay = std::sqrt(3.0 * a * tau + k * k);
  return 1.0 / ((tau + decay) * (1.0 + 2.0 * robin_A * decay / (3.0 * tau)));
}

double slab_over_half_space(double a, double k, double robin_A, double surface_A,
                            double thickness) {
  const double tau = 1.0 + a;
  const std::array<Layer, 1> layers{{{1.0 / (3.0 * tau), a, thickness}}};
  const LayeredMode slab(layers, surface_A, {k * k, 1.0, 0.0});
  return slab.flux_out_near() / diffuse_half_space(a, k, robin_A);
}

}  // namespace kappamu::forward
