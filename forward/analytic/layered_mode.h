// Diffusion in a stack of homogeneous layers, exact, for one lateral wave: light varying as
// cos(k_x x) cos(k_y y) across the stack, whatever its direction, k² = k_x² + k_y². k = 0 is even
// light, and a last layer of infinite thickness a layered half-space.
//
// Within a layer, z counted from the lit surface z = 0:
//     κ φ'' − (μ + κ k²) φ + S(z) = 0,     S(z) = σs' E(z),  σs' = max(0, 1/(3κ) − μ),
// φ and κφ' continuous between layers, φ − 2Aκφ' = q at z = 0 and φ + 2Aκφ' = 0 at the far surface
// (design: first-collision source, E_t, and boundary source, q; either may be 0). S is the
// first-collision source of Mertens' thesis 2.3.1, τ = ∫ dz/(3κ), with the beam reflected to and
// fro between both surfaces (forward/light/beam_column.h): E = D E_t e^(−τ) + U E_t e^(−(T − τ)).
//
// Each layer is eliminated to the values at its two ends (a tridiagonal, diagonally dominant
// system), so nothing overflows in thick layers or at high frequency, nothing is singular at
// 9κμ = 1, and layers may be as thin as one likes. μ = 0 is allowed.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace kappamu::forward {

struct Layer {
  double kappa = 0.0;      ///< κ [mm], > 0
  double mu = 0.0;         ///< μ [1/mm], >= 0
  double thickness = 0.0;  ///< [mm], > 0; infinity is allowed for the last layer
};

/// Amplitudes of the wave, in any one unit of irradiance.
struct ModeSource {
  double wavenumber_squared = 0.0;  ///< k² [1/mm²]
  double beam = 0.0;                ///< collimated irradiance inside the surface, E_t
  double q = 0.0;                   ///< right side of the boundary condition at z = 0
  double reflectance = 0.0;         ///< R of both surfaces for the beam inside, < 1
};

class LayeredMode {
 public:
  /// `robin_A` as in BoundaryConstants::A, > 0. Throws InputError unless layers and source are as
  /// described above.
  LayeredMode(std::span<const Layer> layers, double robin_A, const ModeSource& source);

  /// φ at depth z [mm], 0 ≤ z ≤ the stack's thickness; same unit as the source.
  double fluence(double z) const;
  /// Diffuse flux per area leaving through z = 0, (φ(0) − q)/(2A): negative where more enters.
  double flux_out_near() const;
  /// Diffuse flux per area leaving through the far surface; 0 for a half-space.
  double flux_out_far() const;
  /// What leaves of the beam through z = 0 and through the far surface.
  double unscattered_near() const { return unscattered_near_; }
  double unscattered_far() const { return unscattered_far_; }
  /// First collisions that scatter, ∫ S dz.
  double scattered() const;

 private:
  struct Piece {
    double kappa, decay, extinction, thickness;
    double falling, rising;   // S of the beam away and back, where each comes into the piece
    bool straight() const;    // so thin that γd ≈ 0
    double same_end() const;  // κγ coth γd
    double cross() const;     // κγ / sinh γd
    // Flux that S alone sends through top and bottom, ends held at 0.
    std::array<double, 2> source_flux() const;
    Piece part(double from, double to) const;
  };
  std::vector<Piece> pieces_;
  std::vector<double> value_;  // φ at the surface, the interfaces, the far surface
  double robin_A_, q_;
  double unscattered_near_ = 0.0, unscattered_far_ = 0.0;
};

}  // namespace kappamu::forward
