// What both grid backends agree on before they start: which setups make sense, and the numbers of
// the boundary condition under each convention. Everything else each backend derives on its own.
#pragma once

#include <span>
#include <vector>

#include "core/grid.h"
#include "core/optics.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Throws InputError naming the field unless extents and voxel size are positive and source and
/// convention go together (wang2008 knows the boundary source only).
void validate(const GridSetup& setup);

/// Throws InputError unless κ and μ have one value per voxel, κ finite and positive, μ finite and
/// not negative.
void validate_medium(const GridShape& shape, std::span<const double> kappa,
                     std::span<const double> mu);

/// The Fresnel constants of the setup; A is wang2008_C under that convention.
BoundaryConstants constants_of(const GridSetup& setup);

/// q / E [dimensionless]: the right side of φ + 2Aκ ∂φ/∂n = q per incident irradiance. 4T/(1−R_φ)
/// in the physical convention, T in wang2008 (q = E_t), 0 under the first-collision source.
double boundary_q_per_irradiance(const GridSetup& setup, const BoundaryConstants& constants);

/// Reported exitance per outward diffuse flux −κ ∂φ/∂n: 1, or C under wang2008, where π·L of [W]
/// (3) is −Cκ ∂φ/∂n.
double exitance_per_flux(const GridSetup& setup);

/// Light the lit face reflects diffusely besides the flux of φ, per incident irradiance: M =
/// (φ−q)/(2A) + E_t holds E_t = T·E apart under the physical boundary source; 0 otherwise.
double exitance_per_irradiance(const GridSetup& setup, const BoundaryConstants& constants);

/// True where the face carries the Robin condition, false where it is a mirror.
bool is_open(const GridSetup& setup, Face face);

/// What becomes of a collimated beam of unit power that entered one column, by first events:
/// everything it does not scatter. Power balance: scattered + absorbed + unscattered = 1.
struct BeamFate {
  std::vector<double> scattered;    ///< [z][y][x] fraction first scattered in each voxel
  std::vector<double> unscattered;  ///< [v][u] fraction that leaves by either face
};

/// First-collision fractions (σs'/σt')(e^(−τ_in) − e^(−τ_out)), σt' = 1/(3κ), σs' = max(0, σt' − μ)
/// ([T] 2.3.1 in the similarity-reduced medium), along the columns below the lit face, which the
/// beam passes to and fro (forward/light/beam_column.h).
BeamFate beam_fate(const GridSetup& setup, std::span<const double> kappa,
                   std::span<const double> mu);

}  // namespace kappamu::forward
