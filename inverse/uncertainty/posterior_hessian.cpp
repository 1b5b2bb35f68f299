#include "inverse/uncertainty/posterior_hessian.h"

#include "inverse/optimise/lateral_hessian.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {

PosteriorHessian::PosteriorHessian(Objective& objective, const Prior& prior, int probes,
                                   std::uint64_t seed)
    : objective_(objective),
      prior_(prior),
      basis_(posterior_metric(
          prior, objective.space(),
          prior_blocks(random_rows(objective, probes, seed), objective.space()))) {}

Eigen::VectorXd PosteriorHessian::gradient(const CoefficientPair& by_field) const {
  const Vector z = basis_.gradient(by_field);
  return Eigen::Map<const Eigen::VectorXd>(z.data(), static_cast<Eigen::Index>(z.size()));
}

Eigen::VectorXd PosteriorHessian::product(const Eigen::VectorXd& z) const {
  return gradient(hessian_product(objective_, prior_, to_fields(z)));
}

CoefficientPair PosteriorHessian::to_fields(const Eigen::VectorXd& z) const {
  return basis_.to_fields({z.begin(), z.end()});
}

}  // namespace kappamu::inverse
