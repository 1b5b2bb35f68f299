// Covariances from normal equations that may be singular in places.
#pragma once

#include <Eigen/Core>

namespace ceres {
struct CRSMatrix;
}

namespace kappamu::calib {

Eigen::MatrixXd dense(const ceres::CRSMatrix& sparse);

struct Inverse {
  Eigen::MatrixXd matrix;
  bool regular = false;
};

/// Of a symmetric matrix, scaled to a unit diagonal first: focal lengths in pixels and k3 differ by
/// many decades. Directions that rounding alone fills get nothing.
Inverse inverse_of(const Eigen::MatrixXd& matrix);

}  // namespace kappamu::calib
