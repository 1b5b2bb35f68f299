// Products of dense matrices in vector registers as wide as the machine has: Eigen's are as wide as
// the build was told of, 16 bytes where it has to run anywhere.
#pragma once

#include <Eigen/Core>

namespace kappamu {

/// a · b. The same bits on any machine: every sum runs over the inner index in order, without fused
/// multiply-adds.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace kappamu
