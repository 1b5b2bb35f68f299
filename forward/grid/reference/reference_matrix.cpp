#include "forward/grid/reference/reference_matrix.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers/dot.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::forward::reference {

Matrix::Matrix(const GridSetup& setup, double robin_A, std::span<const double> kappa,
               std::span<const double> mu)
    : shape_(setup.shape),
      stride_{1, static_cast<std::size_t>(shape_.nx),
              static_cast<std::size_t>(shape_.nx) * static_cast<std::size_t>(shape_.ny)} {
  const double h = shape_.voxel_mm;
  const std::size_t n = shape_.cells();
  for (Vector& g : link_) g.assign(n, 0.0);
  diagonal_.resize(n);
  for (std::size_t i = 0; i < n; ++i) diagonal_[i] = mu[i] * h * h * h;
  const auto connect = [&](int axis, std::size_t i) {
    const std::size_t j = i + stride_[static_cast<std::size_t>(axis)];
    const double g = h * 2.0 * kappa[i] * kappa[j] / (kappa[i] + kappa[j]);
    link_[static_cast<std::size_t>(axis)][i] = g;
    diagonal_[i] += g;
    diagonal_[j] += g;
  };
  for (int z = 0; z < shape_.nz; ++z) {
    for (int y = 0; y < shape_.ny; ++y) {
      for (int x = 0; x < shape_.nx; ++x) {
        const std::size_t i = shape_.index(x, y, z);
        if (x + 1 < shape_.nx) connect(0, i);
        if (y + 1 < shape_.ny) connect(1, i);
        if (z + 1 < shape_.nz) connect(2, i);
      }
    }
  }
  for (const Face face : all_faces) {
    Vector& robin = robin_[static_cast<std::size_t>(face)];
    const FaceShape s = face_shape(shape_, face);
    robin.assign(s.cells(), 0.0);
    if (!is_open(setup, face)) continue;
    std::size_t k = 0;
    for (int v = 0; v < s.nv; ++v) {
      for (int u = 0; u < s.nu; ++u, ++k) {
        const std::size_t i = face_cell(shape_, face, u, v);
        robin[k] = h * h / (h / (2.0 * kappa[i]) + 2.0 * robin_A);
        diagonal_[i] += robin[k];
      }
    }
  }
  factorise();
}

void Matrix::apply(const Vector& x, Vector& y) const {
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = diagonal_[i] * x[i];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vector& g = link_[axis];
    for (std::size_t i = 0, j = stride_[axis]; j < x.size(); ++i, ++j) {
      y[i] -= g[i] * x[j];
      y[j] -= g[i] * x[i];
    }
  }
}

void Matrix::precondition(const Vector& r, Vector& z) const {
  const std::size_t n = r.size();
  for (std::size_t i = 0; i < n; ++i) {
    double value = r[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (i < stride_[axis]) continue;
      const std::size_t j = i - stride_[axis];
      value += link_[axis][j] * z[j];
    }
    z[i] = value * inverse_pivot_[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    double value = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t j = i + stride_[axis];
      if (j < n) value += link_[axis][i] * z[j];
    }
    z[i] += value * inverse_pivot_[i];
  }
}

/// Modified incomplete Cholesky without fill (Gustafsson 1978): dropped fill moves to the diagonal,
/// so that smooth functions are treated nearly exactly; moving slightly less than all of it keeps
/// the pivots positive.
void Matrix::factorise() {
  constexpr double moved = 0.97;
  const std::size_t n = diagonal_.size();
  inverse_pivot_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    double pivot = diagonal_[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (i < stride_[axis]) continue;
      const std::size_t j = i - stride_[axis];
      const double g = link_[axis][j];
      const double others = link_[0][j] + link_[1][j] + link_[2][j] - g;
      pivot -= g * (g + moved * others) * inverse_pivot_[j];
    }
    inverse_pivot_[i] = 1.0 / pivot;
  }
}

/// Preconditioned conjugate gradients on one pattern. The residual returned is recomputed from x.
CgResult conjugate_gradients(const Matrix& a, const Vector& b, Vector& x,
                             const SolveOptions& options) {
  const double norm_b = std::sqrt(dot(b, b));
  if (norm_b == 0.0) {
    std::fill(x.begin(), x.end(), 0.0);
    return {};
  }
  const std::size_t n = b.size();
  Vector r(n), z(n), q(n);
  const auto true_residual = [&] {
    a.apply(x, q);
    for (std::size_t i = 0; i < n; ++i) r[i] = b[i] - q[i];
    return std::sqrt(dot(r, r)) / norm_b;
  };
  CgResult result{0, true_residual()};
  // Rounding lets the recursive residual drift from the true one; a restart from the true one
  // mends it, and one that gains nothing has met the limit of double precision.
  double at_restart = std::numeric_limits<double>::infinity();
  while (result.residual > options.tolerance && result.iterations < options.max_iterations &&
         result.residual < 0.5 * at_restart) {
    at_restart = result.residual;
    a.precondition(r, z);
    Vector p = z;
    double rz = dot(r, z);
    double residual = result.residual;
    while (residual > options.tolerance && result.iterations < options.max_iterations) {
      a.apply(p, q);
      const double alpha = rz / dot(p, q);
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
      }
      residual = std::sqrt(dot(r, r)) / norm_b;
      ++result.iterations;
      a.precondition(r, z);
      const double rz_next = dot(r, z);
      const double beta = rz_next / rz;
      rz = rz_next;
      for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + beta * p[i];
    }
    result.residual = true_residual();
  }
  return result;
}

}  // namespace kappamu::forward::reference
