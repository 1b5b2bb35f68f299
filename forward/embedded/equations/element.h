// Trilinear elements: the symmetric 8 × 8 matrix of
//   a(u, v) = ∫ (κ ∇u·∇v + μ u v) dV + ∫ u v / (2A) dA
// over the part of a cube inside the object and its surface. Summed over all cubes it is the weak
// form of ∇·(κ∇φ) − μφ = −S with φ + 2Aκ ∂φ/∂n = q, symmetric positive definite; tested with v = 1
// it is the balance of power, which therefore holds exactly.
#pragma once

#include <array>

#include "core/object_medium.h"
#include "forward/embedded/geometry/cut_cell.h"

namespace kappamu::forward::embedded {

/// A symmetric 8 × 8 matrix, its upper half row by row; nodes as corners of the cube, x fastest.
struct Element {
  static constexpr std::size_t entries = 36;
  std::array<double, entries> entry{};

  static constexpr std::size_t place(std::size_t i, std::size_t j) {
    return i <= j ? 8 * i - i * (i + 1) / 2 + j : place(j, i);
  }
  double operator()(std::size_t i, std::size_t j) const { return entry[place(i, j)]; }
};

/// ∫ N_i N_j over the volume and the surface in a cube and ∫ ∇N_i·∇N_j over the volume, in units of
/// the cube: what a cube's matrix is made of, whatever the coefficients.
struct ElementIntegrals {
  Element stiffness, mass, surface;
};

ElementIntegrals element_integrals(const Moments& volume, const Moments& surface);
/// Of a whole cube.
const ElementIntegrals& whole_integrals();

/// The matrix of a cube of edge h [mm]; A dimensionless.
Element element_of(const ElementIntegrals& integrals, const Coefficients& coefficients, double h,
                   double A);

/// Value of the parent's shape function i at corner `corner` of its child `octant`.
double parent_weight(int octant, int corner, int i);
/// Adds to a cube's matrix that of its child `octant` (Galerkin).
void add_child(Element& parent, const Element& child, int octant);

/// A bound on the eigenvalues of D⁻¹ a, D the matrix's own diagonal.
double scaled_bound(const Element& element);

}  // namespace kappamu::forward::embedded
