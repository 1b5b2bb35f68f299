// Trilinear elements: the symmetric 8 × 8 matrix of
//   a(u, v) = ∫ (κ ∇u·∇v + μ u v) dV + ∫ u v / (2A) dA
// over the part of a cube inside the object and its surface. Summed over all cubes it is the weak
// form of ∇·(κ∇φ) − μφ = −S with φ + 2Aκ ∂φ/∂n = q, symmetric positive definite; tested with v = 1
// it is the balance of power, which therefore holds exactly.
#pragma once

#include <array>

#include "core/object_medium.h"
#include "forward/embedded/cut_cell.h"

namespace kappamu::forward::embedded {

/// Row-major; nodes as corners of the cube, x fastest.
using Element = std::array<double, 64>;

/// Of a whole cube of edge h [mm].
Element whole_element(const Coefficients& coefficients, double h);
/// Of a cut cube: moments over its volume and surface in units of the cube; A dimensionless.
Element cut_element(const Coefficients& coefficients, double h, const Moments& volume,
                    const Moments& surface, double A);

/// Value of the parent's shape function i at corner `corner` of its child `octant`.
double parent_weight(int octant, int corner, int i);
/// Adds to a cube's matrix that of its child `octant` (Galerkin).
void add_child(Element& parent, const Element& child, int octant);

/// A bound on the eigenvalues of D⁻¹ a, D the matrix's own diagonal.
double scaled_bound(const Element& element);

}  // namespace kappamu::forward::embedded
