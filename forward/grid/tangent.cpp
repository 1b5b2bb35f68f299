#include "forward/grid/derivatives.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/grid/grid_physics.h"
#include "forward/light/beam_column.h"

namespace kappamu::forward {

namespace {

/// The derivatives of one medium, term by term as gradient.cpp has them.
struct Linearisation {
  const GridSetup& setup;
  const BoundaryConstants& constants;
  std::span<const double> kappa;
  std::span<const double> mu;
  const CoefficientPair& direction;

  RobinFace robin() const { return {setup.shape.voxel_mm, constants.A}; }
  double conductance(std::size_t cell) const { return robin().conductance(kappa[cell]); }
  /// δ log G_b.
  double log_conductance(std::size_t cell) const {
    return robin().log_slope(kappa[cell]) * direction.log_kappa[cell];
  }

  std::vector<double> faces(int axis) const;
  std::vector<double> diagonal() const;
  std::vector<double> boundary_source() const;
  std::vector<double> first_collisions() const;
  std::vector<double> observed(std::span<const Face> seen) const;
};

/// G_ij = 2h κ_i κ_j/(κ_i + κ_j).
std::vector<double> Linearisation::faces(int axis) const {
  const GridShape& s = setup.shape;
  const std::size_t step = axis == 0   ? 1
                           : axis == 1 ? static_cast<std::size_t>(s.nx)
                                       : static_cast<std::size_t>(s.nx) * s.ny;
  std::vector<double> change(s.cells(), 0.0);
  for_rows(s.ny * s.nz, [&](int row) {
    const int at = axis == 1 ? row % s.ny : row / s.ny;  // of the row along the axis
    if (axis != 0 && at + 1 == s.extent(axis)) return;
    const std::size_t first = static_cast<std::size_t>(row) * s.nx;
    for (std::size_t i = first; i < first + s.nx - (axis == 0 ? 1 : 0); ++i) {
      const std::size_t j = i + step;
      const double sum = kappa[i] + kappa[j];
      change[i] = 2.0 * s.voxel_mm * kappa[i] * kappa[j] / (sum * sum) *
                  (kappa[j] * direction.log_kappa[i] + kappa[i] * direction.log_kappa[j]);
    }
  });
  return change;
}

std::vector<double> Linearisation::diagonal() const {
  const double volume = std::pow(setup.shape.voxel_mm, 3);
  std::vector<double> change(mu.size());
  for_pieces(mu.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) change[i] = volume * mu[i] * direction.log_mu[i];
  });
  for (const Face face : all_faces) {
    if (!is_open(setup, face)) continue;
    const FaceShape shape = face_shape(setup.shape, face);
    for (int v = 0; v < shape.nv; ++v) {
      for (int u = 0; u < shape.nu; ++u) {
        const std::size_t i = face_cell(setup.shape, face, u, v);
        change[i] += conductance(i) * log_conductance(i);
      }
    }
  }
  return change;
}

/// b_i = G_b q on the lit face.
std::vector<double> Linearisation::boundary_source() const {
  const double q = boundary_q_per_irradiance(setup, constants);
  std::vector<double> change(mu.size(), 0.0);
  const FaceShape shape = face_shape(setup.shape, setup.lit_face);
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      const std::size_t i = face_cell(setup.shape, setup.lit_face, u, v);
      change[i] = q * conductance(i) * log_conductance(i);
    }
  }
  return change;
}

/// b_i = h² E_t a_i c_i with c_i of x = h/(3κ) (forward/light/beam_column.h), a = 1 − 3κμ ≥ 0.
std::vector<double> Linearisation::first_collisions() const {
  const GridShape& s = setup.shape;
  const double scale = s.voxel_mm * s.voxel_mm * constants.normal_transmittance;
  std::vector<double> change(mu.size());
  const FaceShape shape = face_shape(s, setup.lit_face);
  const auto depth = static_cast<std::size_t>(s.extent(axis_of(setup.lit_face)));
  for_rows(shape.nv, [&](int v) {
    forward::BeamColumn beam(fresnel_internal(setup.eta, 1.0));
    std::vector<double> x(depth), x_change(depth), collided_change(depth);
    for (int u = 0; u < shape.nu; ++u) {
      const auto cell = [&](std::size_t k) {
        return face_cell(s, setup.lit_face, u, v, static_cast<int>(k));
      };
      for (std::size_t k = 0; k < depth; ++k) {
        x[k] = s.voxel_mm / (3.0 * kappa[cell(k)]);
        x_change[k] = -x[k] * direction.log_kappa[cell(k)];
      }
      beam.set(x);
      beam.change(x_change, collided_change);
      for (std::size_t k = 0; k < depth; ++k) {
        const std::size_t i = cell(k);
        const double absorbed_share = 3.0 * kappa[i] * mu[i];
        if (absorbed_share >= 1.0) continue;
        const double albedo_change =
            -absorbed_share * (direction.log_kappa[i] + direction.log_mu[i]);
        change[i] = scale * (albedo_change * beam.collided(k) +
                             (1.0 - absorbed_share) * collided_change[k]);
      }
    }
  });
  return change;
}

std::vector<double> Linearisation::observed(std::span<const Face> seen) const {
  std::vector<double> change;
  for (const Face face : seen) {
    const FaceShape shape = face_shape(setup.shape, face);
    for (int v = 0; v < shape.nv; ++v) {
      for (int u = 0; u < shape.nu; ++u) {
        change.push_back(log_conductance(face_cell(setup.shape, face, u, v)));
      }
    }
  }
  return change;
}

}  // namespace

Tangent linearise(const GridSetup& setup, const BoundaryConstants& constants,
                  std::span<const Face> seen, std::span<const double> kappa,
                  std::span<const double> mu, const CoefficientPair& direction) {
  const std::size_t cells = setup.shape.cells();
  check(kappa.size() == cells && mu.size() == cells && direction.log_kappa.size() == cells &&
            direction.log_mu.size() == cells,
        "coefficients or direction do not fit the grid");
  const Linearisation at{setup, constants, kappa, mu, direction};
  return {{at.faces(0), at.faces(1), at.faces(2), at.diagonal(),
           setup.source == SourceModel::boundary ? at.boundary_source() : at.first_collisions()},
          at.observed(seen)};
}

}  // namespace kappamu::forward
