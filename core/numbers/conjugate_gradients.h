// Conjugate gradients for a symmetric positive definite A that is known by its products alone.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace kappamu {

/// After a step: x, bᵀx, which grows to bᵀA⁻¹b, what the step added to it, and ‖b − A x‖.
struct GradientStep {
  const Eigen::VectorXd& x;
  double energy = 0.0;
  double gain = 0.0;
  double rest = 0.0;
};

struct GradientSolution {
  Eigen::VectorXd x;
  Eigen::VectorXd rest;  ///< b − A x
};

/// x ≈ A⁻¹ b from 0, by at most `steps` products, fewer where `enough`.
GradientSolution conjugate_gradients(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& product, const Eigen::VectorXd& b,
    int steps, const std::function<bool(const GradientStep&)>& enough);

}  // namespace kappamu
