#include "calib/lens/normal_equations.h"

#include <ceres/crs_matrix.h>

#include "core/numbers/linear_algebra.h"

namespace kappamu::calib {

Eigen::MatrixXd dense(const ceres::CRSMatrix& sparse) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int row = 0; row < sparse.num_rows; ++row) {
    for (int at = sparse.rows[row]; at < sparse.rows[row + 1]; ++at) {
      matrix(row, sparse.cols[at]) = sparse.values[at];
    }
  }
  return matrix;
}

Inverse inverse_of(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd scale = matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * matrix * scale.asDiagonal());
  constexpr double rounding = 1e-13;
  Inverse inverse{Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols()), true};
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
    if (eigen.values[k] < rounding * eigen.values.maxCoeff()) {
      inverse.regular = false;
      continue;
    }
    const Eigen::VectorXd direction = scale.cwiseProduct(eigen.vectors.col(k));
    inverse.matrix += direction * direction.transpose() / eigen.values[k];
  }
  return inverse;
}

}  // namespace kappamu::calib
