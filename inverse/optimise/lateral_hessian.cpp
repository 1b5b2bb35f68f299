#include "inverse/optimise/lateral_hessian.h"

#include <random>
#include <vector>

namespace kappamu::inverse {

namespace {

/// Neighbouring bands on both sides until there are as many samples as rows.
LateralBlocks pooled(const LateralBlocks& sums, const std::vector<int>& samples, int rows,
                     double ridge) {
  const int bins = static_cast<int>(sums.size());
  LateralBlocks blocks;
  for (int bin = 0; bin < bins; ++bin) {
    Eigen::MatrixXd block = sums[static_cast<std::size_t>(bin)];
    int count = samples[static_cast<std::size_t>(bin)];
    for (int reach = 1; count < rows && reach < bins; ++reach) {
      for (const int other : {bin - reach, bin + reach}) {
        if (other < 0 || other >= bins) continue;
        block += sums[static_cast<std::size_t>(other)];
        count += samples[static_cast<std::size_t>(other)];
      }
    }
    block /= std::max(1, count);
    block.diagonal().array() += ridge * block.trace() / rows;
    blocks.push_back(std::move(block));
  }
  return blocks;
}

}  // namespace

std::vector<CoefficientPair> random_rows(Objective& objective, int probes, std::uint64_t seed) {
  std::vector<CoefficientPair> rows;
  std::mt19937_64 engine(seed);
  std::vector<double> probe(objective.problem().data.size());
  for (int k = 0; k < probes; ++k) {
    for (double& sign : probe) sign = (engine() >> 63) != 0 ? 1.0 : -1.0;
    objective.weigh_root(probe);
    rows.push_back(objective.jacobian_transpose(probe));
  }
  return rows;
}

LateralBlocks lateral_blocks(std::span<const CoefficientPair> rows, const GridShape& shape,
                             int depth_axis, double ridge) {
  const LateralModes modes(shape, depth_axis);
  LateralBlocks sums(static_cast<std::size_t>(modes.bins()),
                     Eigen::MatrixXd::Zero(modes.rows(), modes.rows()));
  std::vector<int> samples(sums.size(), 0);
  for (const CoefficientPair& row : rows) {
    const Eigen::MatrixXd waves = modes.analyse(row);
    for (int bin = 0; bin < modes.bins(); ++bin) {
      const Eigen::MatrixXd part = waves(Eigen::all, modes.members(bin));
      sums[static_cast<std::size_t>(bin)] += part * part.transpose();
      samples[static_cast<std::size_t>(bin)] += static_cast<int>(part.cols());
    }
  }
  return pooled(sums, samples, modes.rows(), ridge);
}

LateralBlocks estimate_lateral_blocks(Objective& objective, int depth_axis, int probes,
                                      std::uint64_t seed, double ridge) {
  return lateral_blocks(random_rows(objective, probes, seed), objective.problem().setup.shape,
                        depth_axis, ridge);
}

}  // namespace kappamu::inverse
