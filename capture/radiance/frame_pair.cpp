#include "capture/radiance/frame_pair.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/median.h"

namespace kappamu::capture {
namespace {

constexpr std::size_t least_blocks = 30;
// Nor do blocks whose pixels, in the shorter frame, are fainter than this many deviations of a dark
// one: a recovered response is off there by a share of a code, whose error no number of blocks
// averages out.
constexpr double least_signal_to_dark_noise = 10.0;
// Error of a block that the noise model does not know: the response's bends, dust that moves.
constexpr double relative_floor = 0.002;
constexpr double shift_prior_px = 100.0;  // keeps a picture without edges solvable
constexpr double tukey_constant = 4.685;
constexpr int rounds = 6;
constexpr int parts_across = 8;  // of the picture, each way

struct Equation {
  std::size_t block = 0;
  int part = 0;         // of the picture
  Eigen::Vector3d row;  // of gain, shift x, shift y
  double difference = 0.0;
  double weight = 0.0;  // 1/variance
};

// Difference of radiances = gain * radiance - shift · its gradient, per block.
std::vector<Equation> equations(const Blocks& shorter, const Blocks& longer,
                                const NoiseModel& noise) {
  const auto ta = static_cast<float>(shorter.exposure_s);
  const auto tb = static_cast<float>(longer.exposure_s);
  const double dark_noise = std::sqrt(noise.variance(0.0F));
  const auto radiance = [&](int column, int row) {
    return (shorter.at(column, row) + longer.at(column, row)) / (ta + tb);
  };
  std::vector<Equation> found;
  for (int row = 1; row + 1 < shorter.rows; ++row) {
    for (int column = 1; column + 1 < shorter.columns; ++column) {
      const float either = radiance(column, row);
      if (!std::isfinite(either)) continue;
      const float dx = (radiance(column + 1, row) - radiance(column - 1, row)) / (2.0F * block_px);
      const float dy = (radiance(column, row + 1) - radiance(column, row - 1)) / (2.0F * block_px);
      if (!std::isfinite(dx + dy)) continue;
      const double a = noise.variance(either * ta) / block_pixels / (ta * ta);
      const double b = noise.variance(either * tb) / block_pixels / (tb * tb);
      const double in_shorter = shorter.at(column, row) / ta;
      const double in_longer = longer.at(column, row) / tb;
      // The mean by inverse variance: its error is not that of the difference, so that neither the
      // choice of blocks by it nor the gain multiplied with it is biased.
      const double mean = (in_shorter * b + in_longer * a) / (a + b);
      if (mean < least_signal_to_noise * std::sqrt(a)) continue;
      if (mean * ta < least_signal_to_dark_noise * dark_noise) continue;
      const double floor = relative_floor * mean;
      Equation equation;
      equation.block = static_cast<std::size_t>(row) * shorter.columns + column;
      equation.part = row * parts_across / shorter.rows * parts_across +
                      column * parts_across / shorter.columns;
      equation.row = {mean, -dx, -dy};
      equation.difference = in_longer - in_shorter;
      equation.weight = 1.0 / (a + b + floor * floor);
      found.push_back(equation);
    }
  }
  return found;
}

struct Fit {
  Eigen::Vector3d found = Eigen::Vector3d::Zero();  // gain, shift x, shift y
  Eigen::Matrix3d covariance;
  double spread = 1.0;  // of the residuals in their deviations

  double residual(const Equation& e) const { return e.difference - e.row.dot(found); }
  double tukey_weight(const Equation& e) const {
    const double u = residual(e) * std::sqrt(e.weight) / (tukey_constant * spread);
    return std::abs(u) < 1.0 ? e.weight * (1.0 - u * u) * (1.0 - u * u) : 0.0;
  }
};

// Neighbouring blocks err together where the camera turned, the scene has depth or something in it
// moved: the variances are those of the scatter between parts of the picture, where that is larger
// (Liang & Zeger 1986).
void widen_by_parts(const std::vector<Equation>& all, Fit& fit) {
  std::array<Eigen::Vector3d, parts_across * parts_across> scores;
  scores.fill(Eigen::Vector3d::Zero());
  for (const Equation& e : all) {
    scores[static_cast<std::size_t>(e.part)] += fit.tukey_weight(e) * fit.residual(e) * e.row;
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  int parts = 0;
  for (const Eigen::Vector3d& score : scores) {
    scatter += score * score.transpose();
    parts += score.isZero() ? 0 : 1;
  }
  constexpr int fewest = 8;
  if (parts < fewest) return;
  const Eigen::Matrix3d bread = fit.covariance / (fit.spread * fit.spread);
  const Eigen::Matrix3d robust = bread * scatter * bread * parts / (parts - 1.0);
  const Eigen::Vector3d wider =
      (robust.diagonal().array() / fit.covariance.diagonal().array()).max(1.0).sqrt();
  fit.covariance = wider.asDiagonal() * fit.covariance * wider.asDiagonal();
}

Fit fit(const std::vector<Equation>& all) {
  Fit fit;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> sizes;
    sizes.reserve(all.size());
    for (const Equation& e : all) {
      sizes.push_back(std::abs(fit.residual(e)) * std::sqrt(e.weight));
    }
    fit.spread = std::max(1.0, upper_median(std::move(sizes)) / 0.6745);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Equation& e : all) {
      const double weight = fit.tukey_weight(e);
      normal += weight * e.row * e.row.transpose();
      right += weight * e.difference * e.row;
    }
    const double prior = 1.0 / (shift_prior_px * shift_prior_px);
    normal(1, 1) += prior;
    normal(2, 2) += prior;
    const Eigen::Matrix3d inverse = normal.inverse();
    fit.found = inverse * right;
    fit.covariance = fit.spread * fit.spread * inverse;
  }
  widen_by_parts(all, fit);
  return fit;
}

// The longer frame in one place, its time stretched by the gain until nothing is left of it: the
// equations hold for small gains.
struct Placed {
  double exposure_s = 0.0;
  std::vector<Equation> equations;
  Fit fit;
};

std::optional<Placed> place(const Blocks& shorter, Blocks longer, const NoiseModel& noise) {
  Placed placed;
  constexpr int stretches = 3;
  for (int stretch = 0; stretch < stretches; ++stretch) {
    placed.equations = equations(shorter, longer, noise);
    if (placed.equations.size() < least_blocks) return std::nullopt;
    placed.fit = fit(placed.equations);
    const Eigen::Vector3d& found = placed.fit.found;
    if (!found.allFinite() || found[0] <= -0.9) return std::nullopt;
    longer.exposure_s *= 1.0 + found[0];
  }
  placed.exposure_s = longer.exposure_s;
  return placed;
}

// Whether the blocks that both places see are explained better after the move, beyond what their
// scatter leaves open.
bool fits_better(const Placed& moved, const Placed& before) {
  const double cut = tukey_constant * before.fit.spread;
  double sum = 0.0;
  double squares = 0.0;
  std::size_t count = 0;
  auto other = before.equations.begin();
  for (const Equation& e : moved.equations) {
    while (other != before.equations.end() && other->block < e.block) ++other;
    if (other == before.equations.end()) break;
    if (other->block != e.block) continue;
    const double unit = std::sqrt(other->weight);
    const auto misfit = [&](double residual) {
      return std::pow(std::min(std::abs(residual) * unit, cut), 2);
    };
    const double gain = misfit(before.fit.residual(*other)) - misfit(moved.fit.residual(e));
    sum += gain;
    squares += gain * gain;
    ++count;
  }
  constexpr double certain_deviations = 5.0;
  return count >= least_blocks && sum > certain_deviations * std::sqrt(squares);
}

}  // namespace

std::optional<FramePair> compare_pair(
    const Blocks& shorter, const std::function<Blocks(const Eigen::Vector2i&)>& longer_at,
    const NoiseModel& noise) {
  Eigen::Vector2i offset = Eigen::Vector2i::Zero();
  Blocks longer = longer_at(offset);
  const double stated = longer.exposure_s;
  std::vector<double> logarithms;
  const double faintest = least_signal_to_noise * std::sqrt(noise.variance(0.0F));
  for (std::size_t i = 0; i < shorter.signal.size(); ++i) {
    const bool seen =
        shorter.signal[i] * block_px > faintest && longer.signal[i] * block_px > faintest;
    if (seen) logarithms.push_back(std::log(longer.signal[i] / shorter.signal[i]));
  }
  if (logarithms.size() < least_blocks) return std::nullopt;
  longer.exposure_s = shorter.exposure_s * std::exp(upper_median(std::move(logarithms)));
  std::optional<Placed> placed = place(shorter, std::move(longer), noise);
  if (!placed) return std::nullopt;
  // The equations hold for small shifts: what is left may be another whole pixel.
  const double farthest = block_px * std::min(shorter.columns, shorter.rows) / 4.0;
  constexpr int most_moves = 10;
  for (int move = 0; move < most_moves; ++move) {
    const Eigen::Vector2d left = placed->fit.found.tail<2>();
    constexpr double most_left = 0.6;  // more than half a pixel: no two offsets take turns
    if (left.cwiseAbs().maxCoeff() <= most_left || left.norm() > farthest) break;
    const Eigen::Vector2i next = offset + left.array().round().cast<int>().matrix();
    Blocks moved = longer_at(next);
    moved.exposure_s = placed->exposure_s;
    std::optional<Placed> there = place(shorter, std::move(moved), noise);
    if (!there || !fits_better(*there, *placed)) break;
    placed = std::move(there);
    offset = next;
  }
  const Fit& fitted = placed->fit;
  return FramePair{std::log(placed->exposure_s / stated), fitted.covariance(0, 0),
                   offset.cast<double>() + fitted.found.tail<2>(),
                   std::max(fitted.covariance(1, 1), fitted.covariance(2, 2))};
}

bool is_blank(const Blocks& frame, const Blocks& lit, const NoiseModel& noise) {
  constexpr double far_above_dark = 20.0;  // deviations of a dark pixel
  constexpr double black_share = 0.1;      // of the light promised; and no more than the former
  const double least = far_above_dark * std::sqrt(noise.variance(0.0F));
  const double longer = frame.exposure_s / lit.exposure_s;
  std::size_t blocks = 0, black = 0;
  for (std::size_t i = 0; i < frame.signal.size(); ++i) {
    const double promised = lit.signal[i] * longer;
    const bool compared = lit.signal[i] > least && promised > least;
    if (!compared || !std::isfinite(frame.signal[i])) continue;
    ++blocks;
    black += frame.signal[i] < std::min(least, black_share * promised) ? 1 : 0;
  }
  return blocks >= least_blocks && 10 * black >= 9 * blocks;
}

}  // namespace kappamu::capture
