// Trilinear elements: the symmetric 8 × 8 matrix of
//   a(u, v) = ∫ (κ ∇u·∇v + μ u v) dV + ∫ u v / (2A) dA
// over the part of a cube inside the object and its surface. Summed over all cubes it is the weak
// form of ∇·(κ∇φ) − μφ = −S with φ + 2Aκ ∂φ/∂n = q, symmetric positive definite; tested with v = 1
// it is the balance of power, which therefore holds exactly.
#pragma once

#include "core/object_medium.h"
#include "forward/embedded/geometry/cut_cell.h"
#include "forward/linear/element.h"

namespace kappamu::forward::embedded {

using linear::Element;
using linear::shape_functions;

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
