#include "inverse/uncertainty/missed_structure.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "core/numbers/gaussian_sum.h"

namespace kappamu::inverse {

EvenChange missed_structure(Objective& objective, const CoefficientPair& fields,
                            const PointSpread& spread) {
  const GridShape& shape = objective.problem().setup.shape;
  const Face seen = objective.problem().seen_face;
  const Face first = is_plus(seen) ? opposite(seen) : seen;
  const auto smooth = [&](const std::vector<double>& field, const std::vector<double>& fwhm_mm) {
    return gaussian_means(Volume<double>(shape, field), first, fwhm_mm).values();
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
  const std::size_t cells = shape.cells();
  const std::array<std::vector<double>, 2> by{
      objective.jacobian({Vector(cells, 1.0), Vector(cells, 0.0)}),
      objective.jacobian({Vector(cells, 0.0), Vector(cells, 1.0)})};
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    return Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size()))
        .dot(Eigen::Map<const Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size())));
  };
  Eigen::Matrix2d normal;
  Eigen::Vector2d right;
  for (Eigen::Index k = 0; k < 2; ++k) {
    std::vector<double> weighed = by[static_cast<std::size_t>(k)];
    objective.weigh(weighed);
    normal.col(k) << dot(by[0], weighed), dot(by[1], weighed);
    right(k) = dot(change, weighed);
  }
  const Eigen::Vector2d found = normal.ldlt().solve(right);
  return {found(0), found(1)};
}

}  // namespace kappamu::inverse
