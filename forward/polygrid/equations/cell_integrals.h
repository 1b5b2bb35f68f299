// Integrals of trilinear functions over a deformed cell and over its sides: what the equations of a
// polygrid are made of, whatever the medium.
#pragma once

#include <Eigen/Core>
#include <array>

#include "forward/linear/element.h"
#include "forward/polygrid/cell_geometry.h"

namespace kappamu::forward::polygrid {

struct CellIntegrals {
  /// ∫ ∇u·∇v dV [mm], in mimetic form: exact for gradients that are constant, by the mean gradient
  /// of the trilinear functions; what is left of u, which no constant gradient explains, is weighed
  /// by `edge` (polygrid-diffusion.md). Exact on every deformed cell for linear u, so that the
  /// equations are of second order; on a box all couplings are of the sign that keeps the maximum
  /// principle.
  linear::Element stiffness;
  linear::Element mass;  ///< ∫ u v dV [mm³]
  /// Conductance of each of the four edges along x, y and z of the cell [mm], for κ = 1: the
  /// seven-point form on the same unknowns.
  std::array<double, 3> edge{};
  double volume = 0.0;  ///< [mm³]
};

/// Throws InputError where the cell has no positive volume.
CellIntegrals cell_integrals(const CellCorners& corners);

using linear::shape_functions;

/// The bilinear functions of a side's corners, in the order of side_corners(), at u, v in [0, 1].
std::array<double, 4> side_functions(double u, double v);

/// A Gauss point of a side, of two each way.
struct SidePoint {
  std::array<double, 4> function{};  ///< side_functions() there
  double area = 0.0;                 ///< that it stands for [mm²]
};
std::array<SidePoint, 4> side_points(const std::array<Eigen::Vector3d, 4>& corners);

/// ∫ u v dA over a side [mm²], by its Gauss points; row by row.
using SideMass = std::array<std::array<double, 4>, 4>;
SideMass side_mass(const std::array<Eigen::Vector3d, 4>& corners);

}  // namespace kappamu::forward::polygrid
