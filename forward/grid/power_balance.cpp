#include "forward/grid/power_balance.h"

#include "core/error.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::forward {

std::vector<PowerBalance> power_balance(const GridSolver& solver, const Medium& medium,
                                        const BatchField& phi, std::span<const double> irradiance,
                                        const std::array<std::vector<double>, 6>& exitance) {
  const GridSetup& setup = solver.setup();
  const GridShape& shape = setup.shape;
  const double h = shape.voxel_mm;
  const double transmittance = solver.constants().normal_transmittance;
  const auto patterns = static_cast<std::size_t>(phi.patterns());
  const FaceShape lit = face_shape(shape, setup.lit_face);
  check(irradiance.size() == patterns * lit.cells(), "power_balance: wrong number of irradiances");

  // What a beam of unit power in column k leaves in the block without scattering, and what passes.
  std::vector<double> beam_absorbed(lit.cells(), 0.0), beam_unscattered(lit.cells(), 0.0);
  if (setup.source == SourceModel::first_collision) {
    const BeamFate fate = beam_fate(setup, medium.kappa.values(), medium.mu.values());
    const int depth = shape.extent(axis_of(setup.lit_face));
    for (int v = 0; v < lit.nv; ++v) {
      for (int u = 0; u < lit.nu; ++u) {
        const std::size_t k = static_cast<std::size_t>(v) * lit.nu + u;
        double scattered = 0.0;
        for (int w = 0; w < depth; ++w) {
          scattered += fate.scattered[face_cell(shape, setup.lit_face, u, v, w)];
        }
        beam_unscattered[k] = fate.unscattered[k];
        beam_absorbed[k] = 1.0 - scattered - fate.unscattered[k];
      }
    }
  }

  const std::vector<double> absorbed = solver.weighted_sums(phi, medium.mu.values());
  std::vector<PowerBalance> balances(patterns);
  for (std::size_t m = 0; m < patterns; ++m) {
    PowerBalance& balance = balances[m];
    for (std::size_t k = 0; k < lit.cells(); ++k) {
      const double power = transmittance * irradiance[m * lit.cells() + k] * h * h;
      balance.entering += power;
      balance.unscattered += power * beam_unscattered[k];
      balance.absorbed += power * beam_absorbed[k];
    }
    balance.absorbed += absorbed[m] * h * h * h;
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      const std::size_t samples = exitance[f].size() / patterns;
      for (std::size_t k = 0; k < samples; ++k) {
        balance.exiting[f] += exitance[f][m * samples + k] * h * h;
      }
    }
  }
  return balances;
}

}  // namespace kappamu::forward
