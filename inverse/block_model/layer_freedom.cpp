#include "inverse/block_model/layer_freedom.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/numbers/linear_algebra.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

LayerFreedom layer_freedom(Objective& objective) {
  const MediumSpace& space = objective.space();
  const int layers = std::min(space.depth(), defaults::layer_freedom::layers);
  const LayeredMedium even = with_layers({{0}, {0.0}, {0.0}}, layers, space.depth());
  const Eigen::Index unknowns = 2 * layers;
  const auto data = static_cast<Eigen::Index>(objective.problem().data.size());
  Eigen::MatrixXd by(data, unknowns), normal(unknowns, unknowns);
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    const Eigen::VectorXd one = Eigen::VectorXd::Unit(unknowns, k);
    const std::vector<double> change = objective.jacobian(to_fields(with_unknowns(even, one), space));
    by.col(k) = Eigen::Map<const Eigen::VectorXd>(change.data(), data);
  }
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    std::vector<double> weighed(by.col(k).begin(), by.col(k).end());
    objective.weigh(weighed);
    normal.col(k) = by.transpose() * Eigen::Map<const Eigen::VectorXd>(weighed.data(), data);
  }
  const Eigen::MatrixXd prior = layer_prior(even).rows;
  const Eigen::MatrixXd covariance =
      solve_symmetric(normal + prior.transpose() * prior,
                      Eigen::MatrixXd::Identity(unknowns, unknowns));
  return {std::sqrt(covariance.diagonal().head(layers).minCoeff()),
          std::sqrt(covariance.diagonal().tail(layers).minCoeff())};
}

}  // namespace kappamu::inverse
