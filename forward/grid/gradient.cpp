#include "forward/grid/derivatives.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/grid/grid_physics.h"
#include "forward/light/beam_column.h"

namespace kappamu::forward {

namespace {

/// One coefficient grid seen by the terms of the gradient below.
struct Assembly {
  const GridSetup& setup;
  const BoundaryConstants& constants;
  std::span<const double> kappa;
  std::span<const double> mu;
  const AdjointSums& sums;
  CoefficientPair& gradient;

  RobinFace robin() const { return {setup.shape.voxel_mm, constants.A}; }

  void add_faces(const std::vector<double>& face, int axis);
  void add_cells();
  void add_boundary(Face face);
  void add_observation(Face seen, std::span<const double> observed);
  void add_boundary_source();
  void add_first_collisions();
};

/// −∂G_ij (λ_i − λ_j)(φ_i − φ_j), G_ij = 2h κ_i κ_j/(κ_i + κ_j). Every voxel gathers from its two
/// faces across the axis: no two rows write to one voxel.
void Assembly::add_faces(const std::vector<double>& face, int axis) {
  const GridShape& s = setup.shape;
  const std::ptrdiff_t step = axis == 0   ? 1
                              : axis == 1 ? s.nx
                                          : static_cast<std::ptrdiff_t>(s.nx) * s.ny;
  for_rows(s.ny * s.nz, [&](int row) {
    const std::size_t first = static_cast<std::size_t>(row) * s.nx;
    const double* const k = kappa.data() + first;
    double* const out = gradient.log_kappa.data() + first;
    const auto gather = [&](int begin, int end, std::ptrdiff_t neighbour, const double* product) {
      for (int x = begin; x < end; ++x) {
        const double share = k[x + neighbour] / (k[x] + k[x + neighbour]);
        out[x] -= product[x] * 2.0 * s.voxel_mm * k[x] * share * share;
      }
    };
    const int at = axis == 1 ? row % s.ny : row / s.ny;  // of the row along the axis
    const double* const above = face.data() + first;
    if (axis == 0 || at > 0) gather(axis == 0 ? 1 : 0, s.nx, -step, above - step);
    if (axis == 0 || at + 1 < s.extent(axis)) gather(0, axis == 0 ? s.nx - 1 : s.nx, step, above);
  });
}

/// −∂(μ h³) λ φ.
void Assembly::add_cells() {
  const double volume = std::pow(setup.shape.voxel_mm, 3);
  for_pieces(mu.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      gradient.log_mu[i] -= volume * mu[i] * sums.products.cell[i];
    }
  });
}

/// −∂G_b λ φ.
void Assembly::add_boundary(Face face) {
  if (!is_open(setup, face)) return;
  const FaceShape shape = face_shape(setup.shape, face);
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      const std::size_t i = face_cell(setup.shape, face, u, v);
      gradient.log_kappa[i] -=
          robin().conductance(kappa[i]) * robin().log_slope(kappa[i]) * sums.products.cell[i];
    }
  }
}

/// ψ ∂M/∂κ at fixed φ: M − M_entered is proportional to G_b.
void Assembly::add_observation(Face seen, std::span<const double> observed) {
  const FaceShape shape = face_shape(setup.shape, seen);
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      const std::size_t i = face_cell(setup.shape, seen, u, v);
      const std::size_t s = static_cast<std::size_t>(v) * shape.nu + u;
      gradient.log_kappa[i] += robin().log_slope(kappa[i]) * observed[s];
    }
  }
}

/// λ ∂(G_b q).
void Assembly::add_boundary_source() {
  const double q = boundary_q_per_irradiance(setup, constants);
  const FaceShape shape = face_shape(setup.shape, setup.lit_face);
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      const std::size_t i = face_cell(setup.shape, setup.lit_face, u, v);
      gradient.log_kappa[i] +=
          robin().conductance(kappa[i]) * robin().log_slope(kappa[i]) * q * sums.columns[i];
    }
  }
}

/// λ ∂b, b_i = h² E_t a_i c_i with c_i of optical thicknesses x = h σt' = h/(3κ)
/// (forward/light/beam_column.h) and a = σs'/σt' = 1 − 3κμ. A voxel's κ also shades all others of
/// its column.
void Assembly::add_first_collisions() {
  const GridShape& s = setup.shape;
  const FaceShape shape = face_shape(s, setup.lit_face);
  const auto depth = static_cast<std::size_t>(s.extent(axis_of(setup.lit_face)));
  const double scale = s.voxel_mm * s.voxel_mm * constants.normal_transmittance;
  // From a voxel to the next along the light; less than zero as a remainder modulo 2⁶⁴.
  const std::size_t inwards =
      depth > 1 ? face_cell(s, setup.lit_face, 0, 0, 1) - face_cell(s, setup.lit_face, 0, 0) : 0;
  for_rows(shape.nv, [&](int v) {
    forward::BeamColumn beam(fresnel_internal(setup.eta, 1.0));
    std::vector<double> thickness(depth), weight(depth), by_thickness(depth);
    for (int u = 0; u < shape.nu; ++u) {
      const std::size_t first = face_cell(s, setup.lit_face, u, v);
      std::size_t i = first;
      for (std::size_t k = 0; k < depth; ++k, i += inwards) {
        thickness[k] = s.voxel_mm / (3.0 * kappa[i]);
        weight[k] = scale * sums.columns[i] * std::max(0.0, 1.0 - 3.0 * kappa[i] * mu[i]);
      }
      beam.set(thickness);
      beam.gradient(weight, by_thickness);
      i = first;
      for (std::size_t k = 0; k < depth; ++k, i += inwards) {
        const double absorbed_share = 3.0 * kappa[i] * mu[i];
        const double by_albedo = absorbed_share < 1.0
                                     ? -absorbed_share * scale * sums.columns[i] * beam.collided(k)
                                     : 0.0;
        gradient.log_mu[i] += by_albedo;
        gradient.log_kappa[i] += by_albedo - thickness[k] * by_thickness[k];
      }
    }
  });
}

}  // namespace

void add_gradient(const GridSetup& setup, const BoundaryConstants& constants,
                  std::span<const Face> seen, std::span<const double> kappa,
                  std::span<const double> mu, const AdjointSums& sums, CoefficientPair& gradient) {
  const std::size_t cells = setup.shape.cells();
  check(kappa.size() == cells && mu.size() == cells && gradient.log_mu.size() == cells,
        "coefficients do not fit the grid");
  Assembly assembly{setup, constants, kappa, mu, sums, gradient};
  assembly.add_faces(sums.products.face_x, 0);
  assembly.add_faces(sums.products.face_y, 1);
  assembly.add_faces(sums.products.face_z, 2);
  assembly.add_cells();
  for (const Face face : all_faces) assembly.add_boundary(face);
  std::span<const double> observed(sums.observed);
  for (const Face face : seen) {
    const std::size_t pixels = face_shape(setup.shape, face).cells();
    assembly.add_observation(face, observed.first(pixels));
    observed = observed.subspan(pixels);
  }
  if (setup.source == SourceModel::boundary) {
    assembly.add_boundary_source();
  } else {
    assembly.add_first_collisions();
  }
}

}  // namespace kappamu::forward
