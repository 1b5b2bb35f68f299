#include "inverse/basis.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.h"

namespace kappamu::inverse {

namespace {

Eigen::MatrixXd cosine_matrix(int n) {
  Eigen::MatrixXd matrix(n, n);
  for (int k = 0; k < n; ++k) {
    const double norm = std::sqrt((k == 0 ? 1.0 : 2.0) / n);
    for (int i = 0; i < n; ++i)
      matrix(k, i) = norm * std::cos(std::numbers::pi * k * (i + 0.5) / n);
  }
  return matrix;
}

/// Eigenvalue of the 3-point Neumann Laplacian of n voxels.
double laplacian_eigenvalue(int k, int n) {
  return 2.0 - 2.0 * std::cos(std::numbers::pi * k / n);
}

}  // namespace

Basis::Basis(Coordinates coordinates, const GridShape& shape, double thickness_mm, double length_mm)
    : coordinates_(coordinates),
      shape_(shape),
      voxel_over_thickness_(shape.voxel_mm / thickness_mm) {
  if (coordinates_ == Coordinates::voxels) return;
  for (int axis = 0; axis < 3; ++axis) cosines_.push_back(cosine_matrix(shape.extent(axis)));
  const double mass = std::pow(shape.voxel_mm / length_mm, 2);
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const double eigenvalue = laplacian_eigenvalue(x, shape.nx) +
                                  laplacian_eigenvalue(y, shape.ny) +
                                  laplacian_eigenvalue(z, shape.nz);
        scale_.push_back(1.0 / std::sqrt(voxel_over_thickness_ * (eigenvalue + mass)));
        rough_.push_back(eigenvalue / (eigenvalue + mass));
      }
    }
  }
}

/// Separable: one matrix product per axis.
void Basis::cosine_transform(std::span<double> volume, bool inverse) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int nx = shape_.nx;
  const int ny = shape_.ny;
  const int nz = shape_.nz;
  const auto oriented = [&](int axis) -> Eigen::MatrixXd {
    return inverse ? Eigen::MatrixXd(cosines_[axis].transpose()) : cosines_[axis];
  };
  Eigen::Map<RowMajor> lines(volume.data(), static_cast<Eigen::Index>(ny) * nz, nx);
  lines = (lines * oriented(0).transpose()).eval();
  const Eigen::MatrixXd along_y = oriented(1);
  for (int z = 0; z < nz; ++z) {
    Eigen::Map<RowMajor> slice(volume.data() + static_cast<std::size_t>(z) * ny * nx, ny, nx);
    slice = (along_y * slice).eval();
  }
  Eigen::Map<RowMajor> columns(volume.data(), nz, static_cast<Eigen::Index>(ny) * nx);
  columns = (oriented(2) * columns).eval();
}

CoefficientPair Basis::to_fields(const Vector& z) const {
  check(z.size() == size(), "coordinates do not fit the basis");
  const auto half = static_cast<std::ptrdiff_t>(shape_.cells());
  CoefficientPair fields{Vector(z.begin(), z.begin() + half), Vector(z.begin() + half, z.end())};
  if (coordinates_ == Coordinates::voxels) return fields;
  for (Vector* field : {&fields.log_kappa, &fields.log_mu}) {
    for (std::size_t i = 0; i < field->size(); ++i) (*field)[i] *= scale_[i];
    cosine_transform(*field, true);
  }
  return fields;
}

Vector Basis::from_fields(const CoefficientPair& fields) const {
  Vector z = fields.log_kappa;
  z.insert(z.end(), fields.log_mu.begin(), fields.log_mu.end());
  if (coordinates_ == Coordinates::voxels) return z;
  const std::size_t half = shape_.cells();
  for (const std::size_t begin : {std::size_t{0}, half}) {
    const std::span<double> part(z.data() + begin, half);
    cosine_transform(part, false);
    for (std::size_t i = 0; i < half; ++i) part[i] /= scale_[i];
  }
  return z;
}

Vector Basis::gradient(const CoefficientPair& by_field) const {
  Vector g = by_field.log_kappa;
  g.insert(g.end(), by_field.log_mu.begin(), by_field.log_mu.end());
  if (coordinates_ == Coordinates::voxels) return g;
  const std::size_t half = shape_.cells();
  for (const std::size_t begin : {std::size_t{0}, half}) {
    const std::span<double> part(g.data() + begin, half);
    cosine_transform(part, false);
    for (std::size_t i = 0; i < half; ++i) part[i] *= scale_[i];
  }
  return g;
}

double Basis::roughness(const Vector& z) const {
  const Vector g = roughness_gradient(z);
  double sum = 0.0;
  for (std::size_t i = 0; i < z.size(); ++i) sum += z[i] * g[i];
  return 0.5 * sum;
}

Vector Basis::roughness_gradient(const Vector& z) const {
  Vector g(z.size(), 0.0);
  const std::size_t half = shape_.cells();
  if (coordinates_ == Coordinates::smooth) {
    for (std::size_t i = 0; i < z.size(); ++i) g[i] = rough_[i % half] * z[i];
    return g;
  }
  const auto couple = [&](std::size_t i, std::size_t j) {
    const double slope = voxel_over_thickness_ * (z[i] - z[j]);
    g[i] += slope;
    g[j] -= slope;
  };
  for (const std::size_t begin : {std::size_t{0}, half}) {
    for (int w = 0; w < shape_.nz; ++w) {
      for (int v = 0; v < shape_.ny; ++v) {
        for (int u = 0; u < shape_.nx; ++u) {
          const std::size_t i = begin + shape_.index(u, v, w);
          if (u + 1 < shape_.nx) couple(i, begin + shape_.index(u + 1, v, w));
          if (v + 1 < shape_.ny) couple(i, begin + shape_.index(u, v + 1, w));
          if (w + 1 < shape_.nz) couple(i, begin + shape_.index(u, v, w + 1));
        }
      }
    }
  }
  return g;
}

}  // namespace kappamu::inverse
