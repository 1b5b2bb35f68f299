#include "forward/choice/correction.h"

#include <cmath>
#include <limits>

#include "forward/patches.h"

namespace kappamu::forward {

namespace {

/// Share of an error that lies between the nodes and no walk corrects: on a body with sharp edges,
/// where it is largest.
constexpr double between_nodes = 0.7;
/// Variances: of an average with the weights of a node over that of a cell of the lattice, and of
/// the factor between nodes over theirs; by the weights' squares on a flat surface.
constexpr double of_average = 0.44, of_interpolated = 0.5;

/// How far a factor of this variance is trusted.
double trust(double error, double noise) {
  const double square = error * error;
  return square > 0.0 ? square / (square + noise) : 0.0;
}

}  // namespace

double noise_that_leaves(double error, double wanted) {
  constexpr double cell_over_factor = 1.0 / (of_average * of_interpolated);
  // wanted² = e²n²/(e² + n²) + (between_nodes · e)²
  const double square = wanted * wanted - std::pow(between_nodes * error, 2);
  if (square <= 0.0) return 0.0;
  return square < error * error
             ? std::sqrt(cell_over_factor * square / (1.0 - square / (error * error)))
             : std::numeric_limits<double>::infinity();
}

Correction::Correction(const Surface& surface) : surface_(surface), shares_(surface.size()) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : surface.position) box.extend(p);
  const double edge = box.sizes().maxCoeff() / patches_across;
  constexpr int across = patches_across + 2;
  std::vector<int> known(across * across * across * 6, -1);
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const Eigen::Array3d at = (surface.position[i] - box.min()) / edge;
    const Eigen::Array3d low = at.floor();
    for (int k = 0; k < 24; ++k) {
      const int axis = k % 3;
      const double along = surface.normal[i][axis];
      int node = along > 0.0 ? 2 * axis + 1 : 2 * axis;
      double weight = along * along;
      for (int c = 0; c < 3; ++c) {
        const bool upper = (k / 3 >> c & 1) != 0;
        node = node * across + static_cast<int>(low[c]) + (upper ? 1 : 0);
        weight *= upper ? at[c] - low[c] : 1.0 - (at[c] - low[c]);
      }
      if (weight <= 0.0) continue;
      int& number = known[static_cast<std::size_t>(node)];
      if (number < 0) number = static_cast<int>(nodes_++);
      shares_[i][static_cast<std::size_t>(k)] = {number, static_cast<float>(weight)};
    }
  }
}

std::vector<Correction::Average> Correction::averages(
    std::span<const double> answer, std::span<const double> walk,
    std::span<const double> standard_error) const {
  std::vector<Average> nodes(nodes_);
  double variance = 0.0, power = 0.0;
  for (std::size_t i = 0; i < answer.size(); ++i) {
    const double exiting = surface_.area[i] * answer[i], walked = surface_.area[i] * walk[i];
    for (const Share& share : shares_[i]) {
      Average& node = nodes[static_cast<std::size_t>(share.node)];
      const auto weight = static_cast<double>(share.weight);
      node.answer += weight * exiting;
      node.square += weight * exiting * answer[i];
      node.walk += weight * walked;
      node.noise += weight * weight * exiting;
    }
    power += walked;
    if (walk[i] > 0.0) variance += std::pow(surface_.area[i] * standard_error[i], 2);
  }
  // The variance that the answer leads to expect, in proportion to it: where few photons left, the
  // measured one is low wherever the mean is.
  for (Average& node : nodes) {
    node.noise *= power > 0.0 && node.answer > 0.0
                      ? of_interpolated * variance / power / (node.answer * node.answer)
                      : 0.0;
  }
  return nodes;
}

double Correction::left_by(const std::vector<Average>& averages, double error) {
  double square = 0.0, all = 0.0;
  for (const Average& node : averages) {
    square += node.square * trust(error, node.noise) * node.noise;
    all += node.square;
  }
  return all > 0.0 ? std::hypot(std::sqrt(square / all), between_nodes * error) : 0.0;
}

double Correction::left(std::span<const double> answer, std::span<const double> walk,
                        std::span<const double> standard_error, double error) const {
  return left_by(averages(answer, walk, standard_error), error);
}

CorrectedAnswer Correction::corrected(std::span<const double> answer, std::span<const double> walk,
                                      std::span<const double> standard_error, double error) const {
  const std::vector<Average> nodes = averages(answer, walk, standard_error);
  std::vector<double> factor(nodes_, 1.0);
  for (std::size_t n = 0; n < nodes_; ++n) {
    if (nodes[n].answer <= 0.0) continue;
    factor[n] += trust(error, nodes[n].noise) * (nodes[n].walk / nodes[n].answer - 1.0);
  }
  CorrectedAnswer result{{answer.begin(), answer.end()}, left_by(nodes, error)};
  double walked = 0.0, now = 0.0;
  for (std::size_t i = 0; i < answer.size(); ++i) {
    double own = 0.0;
    for (const Share& share : shares_[i]) {
      own += static_cast<double>(share.weight) * factor[static_cast<std::size_t>(share.node)];
    }
    result.exitance[i] *= own;
    now += surface_.area[i] * result.exitance[i];
    walked += surface_.area[i] * walk[i];
  }
  for (double& value : result.exitance) value *= now > 0.0 ? walked / now : 1.0;
  return result;
}

}  // namespace kappamu::forward
