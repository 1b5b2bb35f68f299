#include "inverse/uncertainty/unresolved_structure.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "core/numbers/gaussian_sum.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse {

EvenChange unresolved_structure(Objective& objective, const CoefficientPair& fields,
                                const PointSpread& spread, const Prior& prior) {
  const MediumSpace& space = objective.space();
  const Face first = all_faces[2 * static_cast<std::size_t>(space.depth_axis)];
  const auto smooth = [&](const std::vector<double>& field, const std::vector<double>& fwhm_mm) {
    return gaussian_means(Volume<double>(space.shape, field), first, fwhm_mm).values();
  };
  if (!std::isfinite(objective.value(
          {smooth(fields.log_kappa, spread.kappa_mm), smooth(fields.log_mu, spread.mu_mm)}))) {
    return {};
  }
  const std::vector<double> smoothed = objective.prediction();
  objective.value(fields);
  const std::vector<double> whole = objective.prediction();
  std::vector<double> change(whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    change[i] = objective.root_weight()[i] * (whole[i] - smoothed[i]);
  }
  const std::size_t cells = space.cells();
  const std::array<CoefficientPair, 2> even{
      CoefficientPair{Vector(cells, 1.0), Vector(cells, 0.0)},
      CoefficientPair{Vector(cells, 0.0), Vector(cells, 1.0)}};
  const std::array<std::vector<double>, 2> by{objective.jacobian(even[0]),
                                              objective.jacobian(even[1])};
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    return Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size()))
        .dot(Eigen::Map<const Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size())));
  };
  Eigen::Matrix2d normal;
  Eigen::Vector2d right;
  for (const Eigen::Index k : {0, 1}) {
    const auto at = static_cast<std::size_t>(k);
    std::vector<double> weighed = by[at];
    objective.weigh(weighed);
    normal.col(k) << dot(by[0], weighed), dot(by[1], weighed);
    right(k) = dot(change, weighed);
    const CoefficientPair anchored = smoothing_product(space, prior.anchor_length_mm, {}, even[at]);
    normal(k, k) += prior.weight * (dot(even[at].log_kappa, anchored.log_kappa) +
                                    dot(even[at].log_mu, anchored.log_mu));
  }
  const Eigen::Vector2d found = normal.ldlt().solve(right);
  return {found(0), found(1)};
}

}  // namespace kappamu::inverse
