#include "inverse/lateral_modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kappamu::inverse {

namespace {

Eigen::MatrixXd cosine_matrix(int n) {
  Eigen::MatrixXd matrix(n, n);
  for (int k = 0; k < n; ++k) {
    const double norm = std::sqrt((k == 0 ? 1.0 : 2.0) / n);
    for (int i = 0; i < n; ++i) {
      matrix(k, i) = norm * std::cos(std::numbers::pi * k * (i + 0.5) / n);
    }
  }
  return matrix;
}

double laplacian_eigenvalue(int k, int n) {
  return 2.0 - 2.0 * std::cos(std::numbers::pi * k / n);
}

}  // namespace

LateralModes::LateralModes(const GridShape& shape, int depth_axis)
    : shape_(shape),
      axis_a_(depth_axis == 0 ? 1 : 0),
      axis_b_(depth_axis == 2 ? 1 : 2),
      depth_axis_(depth_axis),
      na_(shape.extent(axis_a_)),
      nb_(shape.extent(axis_b_)),
      depth_(shape.extent(depth_axis)),
      cosines_a_(cosine_matrix(na_)),
      cosines_b_(cosine_matrix(nb_)) {
  // Bins as wide as the lowest frequency of the longer side.
  const double longest = std::max(na_, nb_);
  for (int b = 0; b < nb_; ++b) {
    for (int a = 0; a < na_; ++a) {
      laplacian_.push_back(laplacian_eigenvalue(a, na_) + laplacian_eigenvalue(b, nb_));
      const double frequency = std::hypot(a * longest / na_, b * longest / nb_);
      const auto bin = static_cast<std::size_t>(std::lround(frequency));
      if (bin >= members_.size()) members_.resize(bin + 1);
      members_[bin].push_back(b * na_ + a);
    }
  }
}

std::size_t LateralModes::voxel(int a, int b, int d) const {
  std::array<int, 3> at{};
  at[static_cast<std::size_t>(axis_a_)] = a;
  at[static_cast<std::size_t>(axis_b_)] = b;
  at[static_cast<std::size_t>(depth_axis_)] = d;
  return shape_.index(at[0], at[1], at[2]);
}

namespace {

/// left · plane · right for each row of `planes`, a depth of one coefficient as [b][a].
Eigen::MatrixXd between_planes(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right,
                               const Eigen::MatrixXd& planes) {
  Eigen::MatrixXd out(planes.rows(), planes.cols());
  for (Eigen::Index row = 0; row < planes.rows(); ++row) {
    const Eigen::VectorXd plane = planes.row(row).transpose();
    const Eigen::Map<const Eigen::MatrixXd> image(plane.data(), left.cols(),
                                                  right.rows());  // column = one b
    const Eigen::MatrixXd image_out = left * image * right;
    out.row(row) = Eigen::Map<const Eigen::RowVectorXd>(image_out.data(), image_out.size());
  }
  return out;
}

}  // namespace

Eigen::MatrixXd LateralModes::transform(const Eigen::MatrixXd& planes, bool inverse) const {
  return inverse ? between_planes(cosines_a_.transpose(), cosines_b_, planes)
                 : between_planes(cosines_a_, cosines_b_.transpose(), planes);
}

Eigen::MatrixXd LateralModes::analyse(const CoefficientPair& fields) const {
  Eigen::MatrixXd planes(rows(), static_cast<Eigen::Index>(na_) * nb_);
  for (int b = 0; b < nb_; ++b) {
    for (int a = 0; a < na_; ++a) {
      for (int d = 0; d < depth_; ++d) {
        planes(d, b * na_ + a) = fields.log_kappa[voxel(a, b, d)];
        planes(depth_ + d, b * na_ + a) = fields.log_mu[voxel(a, b, d)];
      }
    }
  }
  return transform(planes, false);
}

CoefficientPair LateralModes::synthesise(const Eigen::MatrixXd& coefficients) const {
  return fields_of(transform(coefficients, true));
}

CoefficientPair LateralModes::spread(const Eigen::MatrixXd& variances) const {
  return fields_of(
      between_planes(cosines_a_.cwiseAbs2().transpose(), cosines_b_.cwiseAbs2(), variances));
}

CoefficientPair LateralModes::fields_of(const Eigen::MatrixXd& planes) const {
  CoefficientPair fields{std::vector<double>(shape_.cells()), std::vector<double>(shape_.cells())};
  for (int b = 0; b < nb_; ++b) {
    for (int a = 0; a < na_; ++a) {
      for (int d = 0; d < depth_; ++d) {
        fields.log_kappa[voxel(a, b, d)] = planes(d, b * na_ + a);
        fields.log_mu[voxel(a, b, d)] = planes(depth_ + d, b * na_ + a);
      }
    }
  }
  return fields;
}

}  // namespace kappamu::inverse
