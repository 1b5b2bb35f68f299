#include "inverse/linearised.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::inverse {

namespace {

using forward::GridSetup;

/// The derivatives of one medium, term by term as adjoint.cpp has them.
struct Linearisation {
  const GridSetup& setup;
  const BoundaryConstants& constants;
  std::span<const double> kappa;
  std::span<const double> mu;
  const CoefficientPair& direction;

  double conductance(std::size_t cell) const {
    const double h = setup.shape.voxel_mm;
    return h * h / (h / (2.0 * kappa[cell]) + 2.0 * constants.A);
  }
  /// δ log G_b = G_b/(2 h κ) δ log κ.
  double log_conductance(std::size_t cell) const {
    return conductance(cell) / (2.0 * setup.shape.voxel_mm * kappa[cell]) *
           direction.log_kappa[cell];
  }

  std::vector<double> faces(int axis) const;
  std::vector<double> diagonal() const;
  std::vector<double> boundary_source() const;
  std::vector<double> first_collisions() const;
  std::vector<double> observed(Face seen_face) const;
};

std::size_t stride(const GridShape& shape, int axis) {
  return axis == 0   ? 1
         : axis == 1 ? static_cast<std::size_t>(shape.nx)
                     : static_cast<std::size_t>(shape.nx) * shape.ny;
}

/// Calls visit(i, j) for every face between voxels i and j = i's neighbour along `axis`.
template <class Visit>
void for_each_face(const GridShape& s, int axis, Visit visit) {
  const std::size_t step = stride(s, axis);
  for (int z = 0; z < s.nz - (axis == 2 ? 1 : 0); ++z) {
    for (int y = 0; y < s.ny - (axis == 1 ? 1 : 0); ++y) {
      for (int x = 0; x < s.nx - (axis == 0 ? 1 : 0); ++x) {
        const std::size_t i = s.index(x, y, z);
        visit(i, i + step);
      }
    }
  }
}

/// G_ij = 2h κ_i κ_j/(κ_i + κ_j).
std::vector<double> Linearisation::faces(int axis) const {
  std::vector<double> change(setup.shape.cells(), 0.0);
  for_each_face(setup.shape, axis, [&](std::size_t i, std::size_t j) {
    const double sum = kappa[i] + kappa[j];
    change[i] = 2.0 * setup.shape.voxel_mm * kappa[i] * kappa[j] / (sum * sum) *
                (kappa[j] * direction.log_kappa[i] + kappa[i] * direction.log_kappa[j]);
  });
  return change;
}

std::vector<double> Linearisation::diagonal() const {
  const double volume = std::pow(setup.shape.voxel_mm, 3);
  std::vector<double> change(mu.size());
  for (std::size_t i = 0; i < mu.size(); ++i) change[i] = volume * mu[i] * direction.log_mu[i];
  for (const Face face : all_faces) {
    if (!forward::is_open(setup, face)) continue;
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
  const double q = forward::boundary_q_per_irradiance(setup, constants);
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

/// b_i = h² E_t a_i e^(−τ_i) (1 − e^(−x_i)), x = h/(3κ), τ_i = Σ_{above} x, a = 1 − 3κμ ≥ 0.
std::vector<double> Linearisation::first_collisions() const {
  const GridShape& s = setup.shape;
  const double scale = s.voxel_mm * s.voxel_mm * constants.normal_transmittance;
  std::vector<double> change(mu.size());
  const FaceShape shape = face_shape(s, setup.lit_face);
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      double tau = 0.0;
      double tau_change = 0.0;
      for (int k = 0; k < s.extent(axis_of(setup.lit_face)); ++k) {
        const std::size_t i = face_cell(s, setup.lit_face, u, v, k);
        const double x = s.voxel_mm / (3.0 * kappa[i]);
        const double x_change = -x * direction.log_kappa[i];
        const double collided = std::exp(-tau) * -std::expm1(-x);
        const double collided_change = std::exp(-tau - x) * x_change - collided * tau_change;
        const double absorbed_share = 3.0 * kappa[i] * mu[i];
        const double albedo = std::max(0.0, 1.0 - absorbed_share);
        const double albedo_change =
            absorbed_share < 1.0 ? -absorbed_share * (direction.log_kappa[i] + direction.log_mu[i])
                                 : 0.0;
        change[i] = scale * (albedo_change * collided + albedo * collided_change);
        tau += x;
        tau_change += x_change;
      }
    }
  }
  return change;
}

std::vector<double> Linearisation::observed(Face seen_face) const {
  const FaceShape shape = face_shape(setup.shape, seen_face);
  std::vector<double> change;
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      change.push_back(log_conductance(face_cell(setup.shape, seen_face, u, v)));
    }
  }
  return change;
}

/// out −= δG (φ_i − φ_j) for both cells of each face.
void subtract_faces(const GridShape& shape, int axis, const std::vector<double>& change,
                    std::span<const double> phi, std::span<double> out) {
  for_each_face(shape, axis, [&](std::size_t i, std::size_t j) {
    const double flux = change[i] * (phi[i] - phi[j]);
    out[i] -= flux;
    out[j] += flux;
  });
}

}  // namespace

Tangent linearise(const GridSetup& setup, const BoundaryConstants& constants, Face seen_face,
                  std::span<const double> kappa, std::span<const double> mu,
                  const CoefficientPair& direction) {
  const std::size_t cells = setup.shape.cells();
  check(kappa.size() == cells && mu.size() == cells && direction.log_kappa.size() == cells &&
            direction.log_mu.size() == cells,
        "coefficients or direction do not fit the grid");
  const Linearisation at{setup, constants, kappa, mu, direction};
  return {
      at.faces(0),
      at.faces(1),
      at.faces(2),
      at.diagonal(),
      setup.source == forward::SourceModel::boundary ? at.boundary_source() : at.first_collisions(),
      at.observed(seen_face)};
}

std::vector<double> tangent_source(const GridSetup& setup, const Tangent& tangent,
                                   std::span<const double> phi, std::span<const double> irradiance,
                                   int patterns) {
  const std::size_t cells = setup.shape.cells();
  const FaceShape lit = face_shape(setup.shape, setup.lit_face);
  const int depth = setup.shape.extent(axis_of(setup.lit_face));
  check(phi.size() == cells * static_cast<std::size_t>(patterns) &&
            irradiance.size() == lit.cells() * static_cast<std::size_t>(patterns),
        "tangent_source: fields or light do not fit the grid");
  std::vector<double> source(phi.size());
  for_rows(patterns, [&](int pattern) {
    const auto m = static_cast<std::size_t>(pattern);
    const auto field = phi.subspan(m * cells, cells);
    const auto light = irradiance.subspan(m * lit.cells(), lit.cells());
    const auto out = std::span<double>(source).subspan(m * cells, cells);
    for (int v = 0; v < lit.nv; ++v) {
      for (int u = 0; u < lit.nu; ++u) {
        const double e = light[static_cast<std::size_t>(v) * lit.nu + u];
        for (int k = 0; k < depth; ++k) {
          const std::size_t i = face_cell(setup.shape, setup.lit_face, u, v, k);
          out[i] = tangent.source[i] * e - tangent.diagonal[i] * field[i];
        }
      }
    }
    subtract_faces(setup.shape, 0, tangent.face_x, field, out);
    subtract_faces(setup.shape, 1, tangent.face_y, field, out);
    subtract_faces(setup.shape, 2, tangent.face_z, field, out);
  });
  return source;
}

}  // namespace kappamu::inverse
