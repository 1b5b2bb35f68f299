// A block's coefficients as normal scores: each coefficient's values, sorted over the block, become
// those of a standard normal distribution. Sums of scores with Σw² = 1 are then scores again, whose
// values have the block's histogram; the correlation of two coefficients' scores is kept (E. Heitz,
// F. Neyret, High-performance by-example noise using a histogram-preserving blending operator, HPG
// 2018).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/grid.h"
#include "io/volume/volume_set.h"

namespace kappamu::render {

class NormalScores {
 public:
  explicit NormalScores(const io::VolumeSet& block);

  const GridShape& shape() const { return shape_; }
  /// Coefficients: κ and μ of the first channel, then of the next.
  std::size_t count() const { return sorted_.size(); }
  /// Of all coefficients of a voxel.
  std::span<const float> scores(std::size_t voxel) const {
    return {score_.data() + count() * voxel, count()};
  }
  /// Of the scores of a layer, z from 0.
  float layer_mean(std::size_t coefficient, int z) const {
    return layer_mean_[coefficient][static_cast<std::size_t>(z)];
  }
  /// The block's value of this score, in the coefficient's unit.
  double value(std::size_t coefficient, double score) const;

  /// What the scores of a block take [bytes].
  static double bytes(const io::VolumeSet& block);

 private:
  void add(const Volume<double>& values, const std::vector<float>& score_of_rank,
           std::size_t coefficient);

  GridShape shape_;
  std::vector<float> score_;                    ///< [voxel][coefficient]
  std::vector<std::vector<float>> sorted_;      ///< [coefficient][rank], values
  std::vector<std::vector<float>> layer_mean_;  ///< [coefficient][z]
};

}  // namespace kappamu::render
