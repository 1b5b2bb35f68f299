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

/// The waves of some bins of frequency: all of a block's (LateralModes), or those that one process
/// has of a block which several share.
class LateralWaves {
 public:
  virtual ~LateralWaves() = default;

  virtual int depth() const = 0;            ///< voxels along the depth
  int rows() const { return 2 * depth(); }  ///< log κ by depth, then log μ by depth
  virtual int waves() const = 0;            ///< columns of the coefficient matrix
  virtual int bins() const = 0;
  /// Waves whose frequency lies in the bin, as columns of the coefficient matrix.
  virtual const std::vector<int>& members(int bin) const = 0;
  /// Sum of the eigenvalues of the two lateral 3-point Neumann Laplacians [dimensionless], mean
  /// over the waves of the bin.
  virtual double mean_laplacian(int bin) const = 0;

  /// Orthonormal: coefficients [rows][waves].
  virtual Eigen::MatrixXd analyse(const CoefficientPair& fields) const = 0;
  virtual CoefficientPair synthesise(const Eigen::MatrixXd& coefficients) const = 0;
};

class LateralModes final : public LateralWaves {
 public:
  explicit LateralModes(const MediumSpace& space);

  int depth() const override { return depth_; }
  int waves() const override { return na_ * nb_; }
  int bins() const override { return static_cast<int>(members_.size()); }
  const std::vector<int>& members(int bin) const override {
    return members_[static_cast<std::size_t>(bin)];
  }
  /// Per wave.
  const std::vector<double>& laplacian() const { return laplacian_; }
  double mean_laplacian(int bin) const override;

  Eigen::MatrixXd analyse(const CoefficientPair& fields) const override;
  CoefficientPair synthesise(const Eigen::MatrixXd& coefficients) const override;
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
