#include "forward/grid/grid_physics.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/light/beam_column.h"

namespace kappamu::forward {

void validate(const GridSetup& setup) {
  const GridShape& s = setup.shape;
  if (s.nx < 1 || s.ny < 1 || s.nz < 1) {
    throw InputError("grid: every extent must be at least 1 voxel, got " + std::to_string(s.nx) +
                     " x " + std::to_string(s.ny) + " x " + std::to_string(s.nz));
  }
  if (!(std::isfinite(s.voxel_mm) && s.voxel_mm > 0.0)) {
    throw InputError("grid: voxel_mm must be finite and positive, got " +
                     std::to_string(s.voxel_mm));
  }
  if (setup.convention == Convention::wang2008 && setup.source != SourceModel::boundary) {
    throw InputError(
        "convention wang2008 has no first-collision source; choose the boundary source with it");
  }
}

void validate_medium(const GridShape& shape, std::span<const double> kappa,
                     std::span<const double> mu) {
  if (kappa.size() != shape.cells() || mu.size() != shape.cells()) {
    throw InputError("medium: kappa has " + std::to_string(kappa.size()) + " values and mu " +
                     std::to_string(mu.size()) + " where the grid has " +
                     std::to_string(shape.cells()) + " voxels");
  }
  const auto valid = [&](std::size_t i) {
    return std::isfinite(kappa[i]) && kappa[i] > 0.0 && std::isfinite(mu[i]) && mu[i] >= 0.0;
  };
  if (for_all(kappa.size(), valid)) return;
  // Rare: hand the volumes to the one function that words the sentence.
  kappamu::validate(Medium{Volume<double>(shape, std::vector<double>(kappa.begin(), kappa.end())),
                           Volume<double>(shape, std::vector<double>(mu.begin(), mu.end()))},
                    "medium");
}

BoundaryConstants constants_of(const GridSetup& setup) {
  BoundaryConstants constants = boundary_constants(setup.eta);
  if (setup.convention == Convention::wang2008) constants.A = wang2008_C;
  return constants;
}

double boundary_q_per_irradiance(const GridSetup& setup, const BoundaryConstants& constants) {
  if (setup.source != SourceModel::boundary) return 0.0;
  if (setup.convention == Convention::wang2008) return constants.normal_transmittance;
  return constants.normal_transmittance * constants.q_per_entering();
}

double exitance_per_flux(const GridSetup& setup) {
  return setup.convention == Convention::wang2008 ? wang2008_C : 1.0;
}

double exitance_per_irradiance(const GridSetup& setup, const BoundaryConstants& constants) {
  const bool apart =
      setup.source == SourceModel::boundary && setup.convention == Convention::physical;
  return apart ? constants.normal_transmittance : 0.0;
}

bool is_open(const GridSetup& setup, Face face) {
  return setup.sides == Sides::open || axis_of(face) == axis_of(setup.lit_face);
}

BeamFate beam_fate(const GridSetup& setup, std::span<const double> kappa,
                   std::span<const double> mu) {
  const GridShape& shape = setup.shape;
  const FaceShape face = face_shape(shape, setup.lit_face);
  const int depth = shape.extent(axis_of(setup.lit_face));
  BeamFate fate{std::vector<double>(shape.cells()), std::vector<double>(face.cells())};
  BeamColumn column(fresnel_internal(setup.eta, 1.0));
  std::vector<double> thickness(static_cast<std::size_t>(depth));
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      const auto cell = [&](std::size_t w) {
        return face_cell(shape, setup.lit_face, u, v, static_cast<int>(w));
      };
      for (std::size_t w = 0; w < thickness.size(); ++w) {
        thickness[w] = shape.voxel_mm / (3.0 * kappa[cell(w)]);
      }
      column.set(thickness);
      for (std::size_t w = 0; w < thickness.size(); ++w) {
        const std::size_t i = cell(w);
        fate.scattered[i] = std::max(0.0, 1.0 - 3.0 * kappa[i] * mu[i]) * column.collided(w);
      }
      fate.unscattered[static_cast<std::size_t>(v) * face.nu + u] =
          column.leaves_far() + column.leaves_near();
    }
  }
  return fate;
}

}  // namespace kappamu::forward
