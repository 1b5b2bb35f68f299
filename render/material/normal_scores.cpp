#include "render/material/normal_scores.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"

namespace kappamu::render {

namespace {

double normal_share_below(double score) {
  return 0.5 * std::erfc(-score / std::numbers::sqrt2);
}

/// The score of each of `count` ranks: the normal quantile of (rank + 1/2)/count, by Newton's
/// method from the rank before.
std::vector<float> quantiles(std::size_t count) {
  std::vector<float> result(count);
  double score = -6.0;
  for (std::size_t rank = 0; rank < (count + 1) / 2; ++rank) {
    const double share = (static_cast<double>(rank) + 0.5) / static_cast<double>(count);
    for (int step = 0; step < 60; ++step) {
      const double density = std::exp(-0.5 * score * score) / std::sqrt(2.0 * std::numbers::pi);
      const double change = (share - normal_share_below(score)) / density;
      score += std::clamp(change, -0.5, 0.5);
      if (std::abs(change) < 1e-9) break;
    }
    result[rank] = static_cast<float>(score);
    result[count - 1 - rank] = static_cast<float>(-score);
  }
  return result;
}

/// Mean of a voxel and those beside it, so that of equal values those amid high ones rank higher.
std::vector<float> neighbourhood(const Volume<double>& values) {
  const GridShape& s = values.shape();
  std::vector<float> result(values.size());
  for_rows(s.nz * s.ny, [&](int row) {
    const int y = row % s.ny, z = row / s.ny;
    for (int x = 0; x < s.nx; ++x) {
      double sum = 0.0;
      for (int dz = -1; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            sum += values(std::clamp(x + dx, 0, s.nx - 1), std::clamp(y + dy, 0, s.ny - 1),
                          std::clamp(z + dz, 0, s.nz - 1));
          }
        }
      }
      result[s.index(x, y, z)] = static_cast<float>(sum);
    }
  });
  return result;
}

}  // namespace

NormalScores::NormalScores(const io::VolumeSet& block) : shape_(block.shape()) {
  const std::vector<float> score_of_rank = quantiles(shape_.cells());
  sorted_.resize(2 * block.media.size());
  layer_mean_.resize(sorted_.size());
  score_.resize(sorted_.size() * shape_.cells());
  for (std::size_t c = 0; c < block.media.size(); ++c) {
    add(block.media[c].kappa, score_of_rank, 2 * c);
    add(block.media[c].mu, score_of_rank, 2 * c + 1);
  }
}

void NormalScores::add(const Volume<double>& values, const std::vector<float>& score_of_rank,
                       std::size_t coefficient) {
  struct Ranked {
    double value;
    float around;
    std::uint32_t voxel;
  };
  std::vector<Ranked> order;
  order.reserve(values.size());
  const std::vector<float> around = neighbourhood(values);
  for (std::uint32_t i = 0; i < around.size(); ++i) order.push_back({values[i], around[i], i});
  std::sort(order.begin(), order.end(), [](const Ranked& a, const Ranked& b) {
    if (a.value != b.value) return a.value < b.value;
    if (a.around != b.around) return a.around < b.around;
    return mix(a.voxel) < mix(b.voxel);
  });
  const bool constant = order.front().value == order.back().value;
  std::vector<float>& sorted = sorted_[coefficient];
  sorted.resize(values.size());
  const std::size_t layer = shape_.cells() / static_cast<std::size_t>(shape_.nz);
  std::vector<double> sums(static_cast<std::size_t>(shape_.nz));
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const float score = constant ? 0.0F : score_of_rank[rank];
    score_[count() * order[rank].voxel + coefficient] = score;
    sums[order[rank].voxel / layer] += score;
    sorted[rank] = static_cast<float>(order[rank].value);
  }
  for (const double sum : sums)
    layer_mean_[coefficient].push_back(static_cast<float>(sum / static_cast<double>(layer)));
}

double NormalScores::value(std::size_t coefficient, double score) const {
  const std::vector<float>& sorted = sorted_[coefficient];
  const auto count = static_cast<double>(sorted.size());
  const double rank = std::floor(normal_share_below(score) * count);
  return sorted[static_cast<std::size_t>(std::clamp(rank, 0.0, count - 1.0))];
}

double NormalScores::bytes(const io::VolumeSet& block) {
  // Scores and sorted values of each coefficient; the order, quantiles and neighbourhoods of one.
  const auto coefficients = 2.0 * static_cast<double>(block.media.size());
  return static_cast<double>(block.shape().cells()) * (8.0 * coefficients + 24.0);
}

}  // namespace kappamu::render
