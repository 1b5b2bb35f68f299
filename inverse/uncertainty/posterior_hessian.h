// H = JᵀWJ + α R″ of a fit in the coordinates of a metric that guesses it (basis.h): for solves
// with H by conjugate gradients, and what their vectors mean as fields.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "inverse/optimise/basis.h"
#include "inverse/problem/objective.h"
#include "inverse/uncertainty/prior.h"

namespace kappamu::inverse {

class PosteriorHessian {
 public:
  /// At the fields of the objective's last value(), both of which must outlive this; the metric is
  /// made of `probes` adjoint solves.
  PosteriorHessian(Objective& objective, const Prior& prior, int probes, std::uint64_t seed);

  /// Bᵀ of a gradient with respect to the fields.
  Eigen::VectorXd gradient(const CoefficientPair& by_field) const;
  /// Bᵀ H B z: one tangent and one adjoint solve.
  Eigen::VectorXd product(const Eigen::VectorXd& z) const;
  /// B z.
  CoefficientPair to_fields(const Eigen::VectorXd& z) const;

 private:
  Objective& objective_;
  const Prior& prior_;
  Basis basis_;
};

}  // namespace kappamu::inverse
