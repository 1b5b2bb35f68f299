#include "inverse/optimise/lateral_hessian.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::lateral_hessian;

/// Bins on both sides of `bin` that together have `enough` samples, or all there are.
int reach_of(const std::vector<int>& samples, int bin, int enough) {
  const int bins = static_cast<int>(samples.size());
  int count = samples[static_cast<std::size_t>(bin)], reach = 0;
  while (count < enough && reach + 1 < bins) {
    ++reach;
    for (const int other : {bin - reach, bin + reach}) {
      if (other >= 0 && other < bins) count += samples[static_cast<std::size_t>(other)];
    }
  }
  return reach;
}

/// Mean of each band's samples and its neighbours' on both sides, of at least `enough`.
template <class Sum>
std::vector<Sum> pooled(const std::vector<Sum>& sums, const std::vector<int>& samples, int enough) {
  const int bins = static_cast<int>(sums.size());
  std::vector<Sum> means;
  for (int bin = 0; bin < bins; ++bin) {
    Sum sum = sums[static_cast<std::size_t>(bin)];
    int count = samples[static_cast<std::size_t>(bin)];
    const int farthest = reach_of(samples, bin, enough);
    for (int reach = 1; reach <= farthest; ++reach) {
      for (const int other : {bin - reach, bin + reach}) {
        if (other < 0 || other >= bins) continue;
        sum += sums[static_cast<std::size_t>(other)];
        count += samples[static_cast<std::size_t>(other)];
      }
    }
    means.push_back(sum / std::max(1, count));
  }
  return means;
}

}  // namespace

/// A band's matrix as variances and correlations. Variances fall steeply from band to band and need
/// few samples; correlations change slowly and are pooled over more bands.
LateralBlocks pooled_blocks(const LateralBlocks& sums, const std::vector<int>& samples,
                            double ridge) {
  if (sums.empty()) return {};
  const int rows = static_cast<int>(sums.front().rows());
  std::vector<Eigen::VectorXd> squares;
  for (const Eigen::MatrixXd& sum : sums) squares.emplace_back(sum.diagonal());
  std::vector<Eigen::VectorXd> deviations;
  LateralBlocks scaled;
  for (const Eigen::VectorXd& variance : pooled(squares, samples, enough_for_variances)) {
    const double least = std::numeric_limits<double>::min() + 1e-12 * variance.maxCoeff();
    deviations.emplace_back(variance.cwiseMax(least).cwiseSqrt());
    const Eigen::VectorXd inverse = deviations.back().cwiseInverse();
    scaled.push_back(inverse.asDiagonal() * sums[scaled.size()] * inverse.asDiagonal());
  }
  LateralBlocks blocks = pooled(scaled, samples, rows);
  for (std::size_t bin = 0; bin < blocks.size(); ++bin) {
    Eigen::MatrixXd& block = blocks[bin];
    const double least = std::numeric_limits<double>::min();
    const Eigen::VectorXd scale =
        deviations[bin].cwiseQuotient(block.diagonal().cwiseMax(least).cwiseSqrt());
    block = scale.asDiagonal() * block * scale.asDiagonal();
    block.diagonal().array() += ridge * block.trace() / rows;
  }
  return blocks;
}

int pooled_reach(const std::vector<int>& samples, int bin, int rows) {
  return reach_of(samples, bin, std::max(rows, enough_for_variances));
}

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

CoefficientPair estimate_sensitivity(std::span<const CoefficientPair> rows) {
  check(!rows.empty(), "sensitivity: no rows");
  const auto root_mean_square = [&](std::vector<double> CoefficientPair::*of) {
    std::vector<double> root((rows.front().*of).size());
    for (std::size_t i = 0; i < root.size(); ++i) {
      double squares = 0.0;
      for (const CoefficientPair& row : rows) squares += (row.*of)[i] * (row.*of)[i];
      root[i] = std::sqrt(squares / static_cast<double>(rows.size()));
    }
    return root;
  };
  return {root_mean_square(&CoefficientPair::log_kappa),
          root_mean_square(&CoefficientPair::log_mu)};
}

LateralBlocks lateral_sums(std::span<const CoefficientPair> rows, const LateralWaves& waves) {
  LateralBlocks sums(static_cast<std::size_t>(waves.bins()),
                     Eigen::MatrixXd::Zero(waves.rows(), waves.rows()));
  for (const CoefficientPair& row : rows) {
    const Eigen::MatrixXd coefficients = waves.analyse(row);
    for_rows(waves.bins(), [&](int bin) {
      const Eigen::MatrixXd part = coefficients(Eigen::all, waves.members(bin));
      sums[static_cast<std::size_t>(bin)] += part * part.transpose();
    });
  }
  return sums;
}

LateralBlocks lateral_blocks(std::span<const CoefficientPair> rows, const MediumSpace& space,
                             double ridge) {
  const LateralModes modes(space);
  std::vector<int> samples;
  for (int bin = 0; bin < modes.bins(); ++bin) {
    samples.push_back(static_cast<int>(rows.size() * modes.members(bin).size()));
  }
  return pooled_blocks(lateral_sums(rows, modes), samples, ridge);
}

}  // namespace kappamu::inverse
