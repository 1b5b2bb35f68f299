#include "inverse/block_model/layer_freedom.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/numbers/linear_algebra.h"
#include "inverse/block_model/model_layers.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

double LayerFreedom::least_log_mu() const {
  return log_mu.empty() ? 0.0 : *std::min_element(log_mu.begin(), log_mu.end());
}

void LayerFreedom::widen(const LayerFreedom& other) {
  log_kappa.resize(std::max(log_kappa.size(), other.log_kappa.size()));
  log_mu.resize(log_kappa.size());
  for (std::size_t k = 0; k < other.log_kappa.size(); ++k) {
    log_kappa[k] = std::max(log_kappa[k], other.log_kappa[k]);
    log_mu[k] = std::max(log_mu[k], other.log_mu[k]);
  }
}

LayerFreedom layer_freedom(Objective& objective, const MediumSpace& block) {
  const int layers = std::min(block.depth(), defaults::layer_freedom::layers);
  const LayeredMedium even = with_layers({{0}, {0.0}, {0.0}}, layers, block.depth());
  const Eigen::Index unknowns = 2 * layers;
  const auto data = static_cast<Eigen::Index>(objective.problem().data.size());
  Eigen::MatrixXd by(data, unknowns), normal(unknowns, unknowns);
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    const Eigen::VectorXd one = Eigen::VectorXd::Unit(unknowns, k);
    const std::vector<double> change = objective.jacobian(restrict_voxels(
        to_fields(with_unknowns(even, one), block), block.shape, objective.space().shape));
    by.col(k) = Eigen::Map<const Eigen::VectorXd>(change.data(), data);
  }
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    std::vector<double> weighed(by.col(k).begin(), by.col(k).end());
    objective.weigh(weighed);
    normal.col(k) = by.transpose() * Eigen::Map<const Eigen::VectorXd>(weighed.data(), data);
  }
  const Eigen::MatrixXd prior = layer_prior(even).rows;
  const Eigen::MatrixXd covariance = solve_symmetric(normal + prior.transpose() * prior,
                                                     Eigen::MatrixXd::Identity(unknowns, unknowns));
  LayerFreedom freedom;
  for (Eigen::Index l = 0; l < layers; ++l) {
    const auto next = static_cast<std::size_t>(l) + 1;
    const int end = l + 1 < layers ? even.first[next] : block.depth();
    for (int slice = even.first[static_cast<std::size_t>(l)]; slice < end; ++slice) {
      freedom.log_kappa.push_back(std::sqrt(covariance(l, l)));
      freedom.log_mu.push_back(std::sqrt(covariance(layers + l, layers + l)));
    }
  }
  return freedom;
}

}  // namespace kappamu::inverse
