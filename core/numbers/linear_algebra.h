// Products and decompositions of matrices of any size, by Eigen. They are compiled here once: each
// would cost every source that takes it seconds of compiling.
#pragma once

#include <Eigen/Core>

namespace kappamu {

Eigen::MatrixXd product(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right);

/// matrixᵀ · matrix.
Eigen::MatrixXd gram(const Eigen::MatrixXd& matrix);

/// matrix = vectors · diag(values) · vectorsᵀ, values in ascending order.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Of a symmetric matrix; reads the lower triangle.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

/// matrix⁻¹ · right of a square, regular matrix, by LU with rows exchanged.
Eigen::MatrixXd solve(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);

/// matrix⁻¹ · right of a symmetric, positive semidefinite matrix, by LDLᵀ.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);

/// Of a symmetric, positive definite matrix, by LLᵀ; a matrix that is not throws logic_error.
Eigen::MatrixXd inverse_definite(const Eigen::MatrixXd& matrix);

/// The x of the least |matrix · x − right|, column by column, by QR with columns exchanged.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);

/// jacobian · covariance · jacobianᵀ: the covariance of what depends on uncertain numbers so.
Eigen::MatrixXd propagated(const Eigen::MatrixXd& jacobian, const Eigen::MatrixXd& covariance);

/// By QR with columns exchanged from both sides; pivots below `least` of the largest count as zero.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix, double least);

}  // namespace kappamu
