#include "core/numbers/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#include "core/error.h"

namespace kappamu {

Eigen::MatrixXd product(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
  return left * right;
}

Eigen::MatrixXd gram(const Eigen::MatrixXd& matrix) {
  return product(matrix.transpose(), matrix);
}

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd solve(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  return matrix.partialPivLu().solve(right);
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  return matrix.ldlt().solve(right);
}

Eigen::MatrixXd inverse_definite(const Eigen::MatrixXd& matrix) {
  const Eigen::LLT<Eigen::MatrixXd> factors(matrix);
  check(factors.info() == Eigen::Success, "inverse_definite: the matrix is not positive definite");
  return factors.solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  return matrix.colPivHouseholderQr().solve(right);
}

Eigen::MatrixXd propagated(const Eigen::MatrixXd& jacobian, const Eigen::MatrixXd& covariance) {
  return product(product(jacobian, covariance), jacobian.transpose());
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix, double least) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(matrix.rows(),
                                                                        matrix.cols());
  decomposition.setThreshold(least);
  decomposition.compute(matrix);
  return decomposition.pseudoInverse();
}

}  // namespace kappamu
