// The orthonormal DCT-II of the columns of a matrix, of any length: folded in halves as long as the
// length is even (even frequencies see sums of mirrored values, odd ones differences), a dense
// matrix for the rest: a third of the dense work for powers of two.
#pragma once

#include <Eigen/Core>
#include <memory>

namespace kappamu {

class CosineTransform {
 public:
  explicit CosineTransform(int n);

  /// C(k, i) = √(c_k/n) cos(π k (i + ½)/n), c_0 = 1, c_k = 2: [frequency][column] of
  /// [value][column].
  Eigen::MatrixXd forward(const Eigen::MatrixXd& values) const;
  Eigen::MatrixXd inverse(const Eigen::MatrixXd& frequencies) const;

 private:
  Eigen::Index n_;
  std::shared_ptr<const CosineTransform> half_;  ///< of even frequencies; none: dense
  Eigen::MatrixXd matrix_;  ///< of odd frequencies against differences, or the whole
  Eigen::MatrixXd transposed_;
};

}  // namespace kappamu
