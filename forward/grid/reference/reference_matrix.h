// The matrix of the serial reference and its conjugate gradients: see grid_solver.h for the
// equations. Used by reference_solver.cpp only.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "forward/grid/grid_solver.h"

namespace kappamu::forward::reference {

using Vector = std::vector<double>;

/// The matrix of one medium: G towards each cell's +x, +y, +z neighbour and the diagonal; with it a
/// modified incomplete Cholesky factorisation as preconditioner.
class Matrix {
 public:
  Matrix(const GridSetup& setup, double robin_A, std::span<const double> kappa,
         std::span<const double> mu);

  /// G_b of each surface voxel, [v][u]; 0 on mirrors.
  const Vector& robin(Face face) const { return robin_[static_cast<std::size_t>(face)]; }

  /// y = A x
  void apply(const Vector& x, Vector& y) const;

  /// z = (L D Lᵀ)⁻¹ r with L D Lᵀ the incomplete factorisation.
  void precondition(const Vector& r, Vector& z) const;

 private:
  void factorise();

  GridShape shape_;
  std::array<std::size_t, 3> stride_;
  std::array<Vector, 3> link_;   ///< [axis][z][y][x], 0 where there is no neighbour
  std::array<Vector, 6> robin_;  ///< [face][v][u]
  Vector diagonal_;
  Vector inverse_pivot_;
};

struct CgResult {
  int iterations = 0;
  double residual = 0.0;  ///< ‖b − A x‖/‖b‖, recomputed from x
};

/// Preconditioned conjugate gradients on one pattern, starting from x.
CgResult conjugate_gradients(const Matrix& a, const Vector& b, Vector& x,
                             const SolveOptions& options);

}  // namespace kappamu::forward::reference
