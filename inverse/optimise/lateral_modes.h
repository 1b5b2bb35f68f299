// Fields of a block as lateral waves: cosines (DCT-II) along the two axes across the depth, nothing
// along the depth itself. Operators that are nearly invariant under lateral shifts couple few
// waves of different frequency: the regulariser, and the data's Hessian if patterns cover the lit
// face. Each becomes one small matrix per frequency, over depth and coefficient.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/numbers/cosine_transform.h"
#include "inverse/problem/fields.h"

namespace kappamu::inverse {

/// Eigenvalue of the 3-point Neumann Laplacian of `n` voxels for the cosine of k half periods.
double laplacian_eigenvalue(int k, int n);

class LateralModes {
 public:
  explicit LateralModes(const MediumSpace& space);

  int depth() const { return depth_; }     ///< voxels along the depth
  int rows() const { return 2 * depth_; }  ///< log κ by depth, then log μ by depth
  int bins() const { return static_cast<int>(members_.size()); }
  /// Waves whose frequency lies in the bin, as columns of the coefficient matrix.
  const std::vector<int>& members(int bin) const { return members_[static_cast<std::size_t>(bin)]; }
  /// Sum of the eigenvalues of the two lateral 3-point Neumann Laplacians, per wave
  /// [dimensionless].
  const std::vector<double>& laplacian() const { return laplacian_; }
  /// Its mean over the waves of the bin.
  double mean_laplacian(int bin) const;

  /// Orthonormal: coefficients [rows][waves].
  Eigen::MatrixXd analyse(const CoefficientPair& fields) const;
  CoefficientPair synthesise(const Eigen::MatrixXd& coefficients) const;
  /// Variances of the fields whose coefficients are independent from wave to wave and have the
  /// variances [rows][waves].
  CoefficientPair spread(const Eigen::MatrixXd& variances) const;

 private:
  template <class Field>
  auto plane(Field& field, int d) const;
  template <class Work>
  void for_planes(const Work& work) const;
  template <class Back>
  CoefficientPair fields_of(const Eigen::MatrixXd& coefficients, const Back& back) const;

  GridShape shape_;
  int axis_a_ = 0;
  int axis_b_ = 1;
  int depth_axis_ = 2;
  int na_ = 1;
  int nb_ = 1;
  int depth_ = 1;
  CosineTransform cosines_a_;
  CosineTransform cosines_b_;
  std::vector<double> laplacian_;
  std::vector<std::vector<int>> members_;
};

}  // namespace kappamu::inverse
