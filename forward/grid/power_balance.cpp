#include "forward/grid/power_balance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

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

  std::vector<double> fluence(shape.cells() * patterns);
  solver.read(phi, fluence);
  std::vector<PowerBalance> balances(patterns);
  for (std::size_t m = 0; m < patterns; ++m) {
    PowerBalance& balance = balances[m];
    for (std::size_t k = 0; k < lit.cells(); ++k) {
      const double power = transmittance * irradiance[m * lit.cells() + k] * h * h;
      balance.entering += power;
      balance.unscattered += power * beam_unscattered[k];
      balance.absorbed += power * beam_absorbed[k];
    }
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      balance.absorbed += medium.mu[i] * fluence[m * shape.cells() + i] * h * h * h;
    }
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      const std::size_t samples = exitance[f].size() / patterns;
      for (std::size_t k = 0; k < samples; ++k) {
        balance.exiting[f] += exitance[f][m * samples + k] * h * h;
      }
    }
  }
  return balances;
}

namespace {

/// A smaller share of the block than this is not worth a warning: a fit always has some voxel at
/// the end of its range.
constexpr double worthwhile_share = 0.01;

/// Voxel edge over mean free path 3κ above which the grid's own error of an even beam's reflected
/// and transmitted light exceeds 3 % (first collision) or 2 % (boundary): docs/limits.md, coarse.
double coarsest_voxel(SourceModel source) {
  return source == SourceModel::first_collision ? 1.0 : 4.0;
}

std::optional<std::string> much_absorption(const Medium& medium) {
  constexpr double much = 0.1;  // μ/σt', where P1 and transport part visibly
  std::size_t absorbing = 0, without_scattering = 0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    const double ratio = 3.0 * medium.kappa[i] * medium.mu[i];
    absorbing += ratio > much ? 1 : 0;
    without_scattering += ratio >= 1.0 ? 1 : 0;
  }
  const double share = static_cast<double>(absorbing) / static_cast<double>(medium.kappa.size());
  if (share < worthwhile_share && without_scattering == 0) return std::nullopt;
  std::ostringstream out;
  out << 100.0 * share
      << " % of the voxels absorb more than a tenth of what they extinguish (3 kappa mu > 0.1); "
         "diffusion is inaccurate there";
  if (without_scattering > 0) {
    out << ", and in " << without_scattering << " voxels no scattering is left (3 kappa mu >= 1)";
  }
  return out.str();
}

std::optional<std::string> thin_block(const GridSetup& setup, const Medium& medium) {
  constexpr double few_mean_free_paths = 4.0;
  double inverse = 0.0;
  for (const double kappa : medium.kappa.values()) inverse += 1.0 / (3.0 * kappa);
  const double depth = setup.shape.extent(axis_of(setup.lit_face)) * setup.shape.voxel_mm;
  const double paths = depth * inverse / static_cast<double>(medium.kappa.size());
  if (paths >= few_mean_free_paths) return std::nullopt;
  std::ostringstream out;
  out << "the block is only " << paths
      << " transport mean free paths thick along the light; diffusion needs about "
      << few_mean_free_paths << " to hold within a few percent";
  return out.str();
}

std::optional<std::string> coarse_voxels(const GridSetup& setup, const Medium& medium) {
  const double h = setup.shape.voxel_mm;
  const double limit = coarsest_voxel(setup.source);
  std::size_t coarse = 0;
  double worst = 0.0;
  for (const double kappa : medium.kappa.values()) {
    const double paths = h / (3.0 * kappa);
    // A voxel of just one mean free path is not beyond it for want of a last digit.
    coarse += paths > limit * (1.0 + 1e-9) ? 1 : 0;
    worst = std::max(worst, paths);
  }
  const double share = static_cast<double>(coarse) / static_cast<double>(medium.kappa.size());
  if (share < worthwhile_share) return std::nullopt;
  std::ostringstream out;
  out << "in " << 100.0 * share << " % of the block the voxel edge of " << h << " mm is more than "
      << limit << (limit > 1.0 ? " mean free paths" : " mean free path") << " 3 kappa (up to "
      << worst
      << "); the grid's own error exceeds a few percent there: split the voxels and compare";
  return out.str();
}

std::optional<std::string> dark_far_side(const GridSetup& setup, const Medium& medium) {
  constexpr double most_decades = 6.0;     // the default tolerance's
  constexpr double double_decades = 13.0;  // what double still resolves
  double decay = 0.0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    decay += std::sqrt(medium.mu[i] / medium.kappa[i]);
  }
  const double depth = setup.shape.extent(axis_of(setup.lit_face)) * setup.shape.voxel_mm;
  const double decades =
      decay / static_cast<double>(medium.kappa.size()) * depth / std::numbers::ln10;
  if (decades <= most_decades) return std::nullopt;
  std::ostringstream out;
  out << "light falls by about " << std::round(decades)
      << " decades across the block, more than the default tolerance resolves; what leaves the far "
         "face is rounding unless you ask for ";
  if (decades <= double_decades) {
    out << "--precision double and --tolerance 1e-" << std::ceil(decades);
  } else {
    out << "a thinner block: no precision resolves it";
  }
  return out.str();
}

}  // namespace

std::vector<std::string> diffusion_warnings(const GridSetup& setup, const Medium& medium) {
  std::vector<std::string> warnings;
  for (const auto& sentence : {much_absorption(medium), thin_block(setup, medium),
                               coarse_voxels(setup, medium), dark_far_side(setup, medium)}) {
    if (sentence) warnings.push_back(*sentence);
  }
  return warnings;
}

}  // namespace kappamu::forward
