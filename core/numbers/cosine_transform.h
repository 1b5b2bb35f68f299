// The orthonormal DCT-II of any length: C(k, i) = √(c_k/n) cos(π k (i + ½)/n), c_0 = 1, c_k = 2. An
// even length is halved, by rotations alone, so that rounding does not grow (Plonka and Tasche,
// "Fast and numerically stable algorithms for discrete cosine transforms", 2005); a short or odd
// one is a dense matrix.
#pragma once

#include <Eigen/Core>
#include <memory>

namespace kappamu {

class CosineTransform {
 public:
  explicit CosineTransform(int n);

  /// Of the columns: [frequency][column] of [value][column]. The same bits on any machine.
  Eigen::MatrixXd forward(const Eigen::MatrixXd& values) const;
  Eigen::MatrixXd inverse(const Eigen::MatrixXd& frequencies) const;

  struct Length;  ///< what transforms of one length need
  const Length& length() const { return *length_; }

 private:
  std::shared_ptr<const Length> length_;
};

/// Of an image [a][b], along both axes.
Eigen::MatrixXd to_waves(const CosineTransform& a, const CosineTransform& b, Eigen::MatrixXd image);
Eigen::MatrixXd from_waves(const CosineTransform& a, const CosineTransform& b,
                           Eigen::MatrixXd frequencies);
/// The same in place, column after column.
void to_waves(const CosineTransform& a, const CosineTransform& b, double* image);
void from_waves(const CosineTransform& a, const CosineTransform& b, double* frequencies);

}  // namespace kappamu
