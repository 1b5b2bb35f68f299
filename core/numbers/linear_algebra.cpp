#include "core/numbers/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace kappamu {

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  return matrix.ldlt().solve(right);
}

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  return matrix.colPivHouseholderQr().solve(right);
}

Eigen::MatrixXd propagated(const Eigen::MatrixXd& jacobian, const Eigen::MatrixXd& covariance) {
  return jacobian * covariance * jacobian.transpose();
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix, double least) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(matrix.rows(),
                                                                        matrix.cols());
  decomposition.setThreshold(least);
  decomposition.compute(matrix);
  return decomposition.pseudoInverse();
}

}  // namespace kappamu
