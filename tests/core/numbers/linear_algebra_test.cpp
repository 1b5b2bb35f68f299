// Decompositions against what they promise, on matrices drawn at random.
#include "core/numbers/linear_algebra.h"

#include <random>

#include <gtest/gtest.h>

namespace kappamu {
namespace {

Eigen::MatrixXd drawn(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(engine); });
}

TEST(LinearAlgebra, EigenvectorsGiveTheMatrixBackInAscendingOrder) {
  const Eigen::MatrixXd half = drawn(12, 12, 1);
  const Eigen::MatrixXd matrix = half + half.transpose();
  const SymmetricEigen eigen = symmetric_eigen(matrix);
  EXPECT_LT((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose() - matrix).norm(),
            1e-13 * matrix.norm());
  EXPECT_TRUE(std::is_sorted(eigen.values.begin(), eigen.values.end()));
}

TEST(LinearAlgebra, SolvesAlsoWhatIsBarelyDefinite) {
  const Eigen::MatrixXd half = drawn(10, 7, 4);
  const Eigen::MatrixXd matrix = half * half.transpose() + 1e-8 * Eigen::MatrixXd::Identity(10, 10);
  const Eigen::MatrixXd right = matrix * drawn(10, 3, 5);
  EXPECT_LT((matrix * solve_symmetric(matrix, right) - right).norm(), 1e-7 * right.norm());
}

TEST(LinearAlgebra, AnInverseIsOfDefiniteMatricesAlone) {
  const Eigen::MatrixXd half = drawn(10, 12, 2);
  const Eigen::MatrixXd matrix = half * half.transpose();
  EXPECT_LT((matrix * inverse_definite(matrix) - Eigen::MatrixXd::Identity(10, 10)).norm(), 1e-9);
  EXPECT_THROW(inverse_definite(-matrix), std::logic_error);
}

TEST(LinearAlgebra, SolvesWhatIsNotSymmetric) {
  const Eigen::MatrixXd matrix = drawn(10, 10, 11), right = drawn(10, 3, 12);
  EXPECT_LT((product(matrix, solve(matrix, right)) - right).norm(), 1e-11 * right.norm());
}

TEST(LinearAlgebra, LeastSquaresLeaveAResidualAcrossTheColumns) {
  const Eigen::MatrixXd matrix = drawn(30, 6, 6);
  const Eigen::MatrixXd right = drawn(30, 2, 7);
  const Eigen::MatrixXd residual = right - matrix * least_squares(matrix, right);
  EXPECT_LT((matrix.transpose() * residual).norm(), 1e-12 * matrix.norm() * right.norm());
  EXPECT_GT(residual.norm(), 0.1 * right.norm());
}

TEST(LinearAlgebra, PseudoInverseLeavesOutWhatIsBelow) {
  const Eigen::MatrixXd matrix = drawn(12, 5, 8) * drawn(5, 9, 9);
  const Eigen::MatrixXd noise = 1e-13 * drawn(12, 9, 10);
  const Eigen::MatrixXd inverse = pseudo_inverse(matrix + noise, 1e-10);
  EXPECT_LT((matrix * inverse * matrix - matrix).norm(), 1e-10 * matrix.norm());
  EXPECT_LT((inverse - pseudo_inverse(matrix, 1e-10)).norm(), 1e-9 * inverse.norm());
}

}  // namespace
}  // namespace kappamu
