#include "capture/radiance/steadiness.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "capture/response/frame_reader.h"
#include "capture/response/noise_model.h"
#include "core/numbers/median.h"

namespace kappamu::capture {
namespace {

constexpr int block_px = 4;
constexpr double block_pixels = block_px * block_px;
constexpr int smallest_frame_px = 3 * block_px;
constexpr std::size_t least_blocks = 30;
// Blocks fainter than this many of their standard deviations in the shorter frame say little of
// gain.
constexpr double least_signal_to_noise = 5.0;
// Nor blocks whose pixels, in the shorter frame, are fainter than this many deviations of a dark
// one: a recovered response is off there by a share of a code, whose error no number of blocks
// averages out.
constexpr double least_signal_to_dark_noise = 10.0;
// Blocks nearer to saturation than this are left out: some of their pixels are cut.
constexpr float near_saturation = 0.9F;
// Error of a block that the noise model does not know: the response's bends, dust that moves.
constexpr double relative_floor = 0.002;
constexpr double shift_prior_px = 100.0;  // keeps a picture without edges solvable
constexpr double tukey_constant = 4.685;
constexpr int rounds = 6;
constexpr double changed_deviations = 6.0;
constexpr double changed_relative = 0.1;
constexpr double shifted_px = 0.1;

// Mean linear signal of the blocks of one frame; not a number where a pixel is saturated.
struct Blocks {
  int columns = 0;
  int rows = 0;
  double exposure_s = 0.0;
  std::vector<float> signal;

  float at(int column, int row) const {
    return signal[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(column)];
  }
};

template <class Reader>
Blocks block_means(const Image<typename Reader::Value>& image, double exposure_s,
                   const Reader& reader, int channel) {
  Blocks blocks{image.width() / block_px, image.height() / block_px, exposure_s, {}};
  const float limit = near_saturation * reader.saturation();
  for (int row = 0; row < blocks.rows; ++row) {
    for (int column = 0; column < blocks.columns; ++column) {
      float sum = 0.0F;
      bool saturated = false;
      for (int y = row * block_px; y < (row + 1) * block_px; ++y) {
        for (int x = column * block_px; x < (column + 1) * block_px; ++x) {
          const auto value = image(x, y, channel);
          saturated |= reader.saturated(value);
          sum += reader.linear(value);
        }
      }
      const float mean = sum / static_cast<float>(block_pixels);
      blocks.signal.push_back(saturated || mean > limit ? std::nanf("") : mean);
    }
  }
  return blocks;
}

struct Pair {
  double log_gain = 0.0;  // of the longer frame relative to the shorter
  double gain_variance = 0.0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  // [px], likewise
  double shift_variance = 0.0;
};

struct Equation {
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
      const float dx = (radiance(column + 1, row) - radiance(column - 1, row)) / (2.0F * block_px);
      const float dy = (radiance(column, row + 1) - radiance(column, row - 1)) / (2.0F * block_px);
      if (!std::isfinite(either + dx + dy)) continue;
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
};

Fit fit(const std::vector<Equation>& all) {
  Fit fit;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> sizes;
    sizes.reserve(all.size());
    for (const Equation& e : all) {
      sizes.push_back(std::abs(e.difference - e.row.dot(fit.found)) * std::sqrt(e.weight));
    }
    const double spread = std::max(1.0, upper_median(sizes) / 0.6745);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double u = sizes[i] / (tukey_constant * spread);
      if (u >= 1.0) continue;
      const double weight = all[i].weight * (1.0 - u * u) * (1.0 - u * u);
      normal += weight * all[i].row * all[i].row.transpose();
      right += weight * all[i].difference * all[i].row;
    }
    const double prior = 1.0 / (shift_prior_px * shift_prior_px);
    normal(1, 1) += prior;
    normal(2, 2) += prior;
    fit.found = normal.ldlt().solve(right);
    fit.covariance = spread * spread * normal.inverse();
  }
  return fit;
}

// The longer frame's time is stretched by the gain found so far, until nothing is left of it: the
// equations hold for small gains. It begins with the median ratio.
std::optional<Pair> compare(const Blocks& shorter, Blocks longer, const NoiseModel& noise) {
  const double told = longer.exposure_s;
  std::vector<double> logarithms;
  const double faintest = least_signal_to_noise * std::sqrt(noise.variance(0.0F));
  for (std::size_t i = 0; i < shorter.signal.size(); ++i) {
    const bool seen =
        shorter.signal[i] * block_px > faintest && longer.signal[i] * block_px > faintest;
    if (seen) logarithms.push_back(std::log(longer.signal[i] / shorter.signal[i]));
  }
  if (logarithms.size() < least_blocks) return std::nullopt;
  longer.exposure_s = shorter.exposure_s * std::exp(upper_median(std::move(logarithms)));
  Pair pair;
  constexpr int stretches = 3;
  for (int stretch = 0; stretch < stretches; ++stretch) {
    const std::vector<Equation> all = equations(shorter, longer, noise);
    if (all.size() < least_blocks) return std::nullopt;
    const Fit fitted = fit(all);
    if (!fitted.found.allFinite() || fitted.found[0] <= -0.9) return std::nullopt;
    longer.exposure_s *= 1.0 + fitted.found[0];
    pair.gain_variance = fitted.covariance(0, 0);
    pair.shift = fitted.found.tail<2>();
    pair.shift_variance = std::max(fitted.covariance(1, 1), fitted.covariance(2, 2));
  }
  pair.log_gain = std::log(longer.exposure_s / told);
  return pair;
}

// Places the frames of a chain of comparable neighbours relative to the chain's median.
void place_chain(const std::vector<std::size_t>& chain, const std::vector<Pair>& steps,
                 Steadiness& states) {
  std::vector<double> gains{0.0};
  std::vector<double> x{0.0};
  std::vector<double> y{0.0};
  for (const Pair& step : steps) {
    gains.push_back(gains.back() + step.log_gain);
    x.push_back(x.back() + step.shift[0]);
    y.push_back(y.back() + step.shift[1]);
  }
  const double gain = upper_median(gains);
  const double middle_x = upper_median(x);
  const double middle_y = upper_median(y);
  const auto middle =
      static_cast<std::size_t>(std::find(gains.begin(), gains.end(), gain) - gains.begin());
  for (std::size_t i = 0; i < chain.size(); ++i) {
    FrameState state;
    state.log_gain = gains[i] - gain;
    state.shift_px = {x[i] - middle_x, y[i] - middle_y};
    // Errors add up along the chain from the middle frame, which has that of the step beside it.
    double gain_variance = 0.0;
    double shift_variance = 0.0;
    const std::size_t first = std::min({i, middle, steps.size() - 1});
    const std::size_t last = std::max({i, middle, first + 1});
    for (std::size_t step = first; step < last; ++step) {
      gain_variance += steps[step].gain_variance;
      shift_variance += steps[step].shift_variance;
    }
    state.log_gain_sigma = std::sqrt(gain_variance);
    state.shift_sigma_px = std::sqrt(shift_variance);
    states[chain[i]] = state;
  }
}

// Share of each frame's blocks that differ from the median of all frames that see them, gains
// corrected. Two frames that disagree alone share the blame. Shifted frames are left out: they
// differ everywhere, and that is told already.
void find_changes(const std::vector<Blocks>& frames, const NoiseModel& noise, Steadiness& states) {
  struct Seen {
    std::size_t frame;
    double radiance;
    double variance;
  };
  struct Difference {
    double deviations;
    bool large;
    double blame;
  };
  std::vector<std::vector<Difference>> differences(frames.size());
  for (std::size_t i = 0; i < frames.front().signal.size(); ++i) {
    std::vector<Seen> seen;
    std::vector<double> radiances;
    for (std::size_t j = 0; j < frames.size(); ++j) {
      const float signal = frames[j].signal[i];
      if (!states[j] || !std::isfinite(signal)) continue;
      if (std::hypot(states[j]->shift_px[0], states[j]->shift_px[1]) > shifted_px) continue;
      const double time = frames[j].exposure_s * std::exp(states[j]->log_gain);
      seen.push_back({j, signal / time, noise.variance(signal) / block_pixels / (time * time)});
    }
    // Pixels near black may be cut off there: a frame has its say where its pixels stand well above
    // their noise, and is judged where the others promise that.
    const auto bright = [&](const Seen& one, double radiance) {
      const double time = frames[one.frame].exposure_s * std::exp(states[one.frame]->log_gain);
      const double signal = radiance * time;
      return signal > least_signal_to_noise * std::sqrt(noise.variance(signal));
    };
    for (const Seen& one : seen) {
      if (bright(one, one.radiance)) radiances.push_back(one.radiance);
    }
    if (radiances.size() < 2) continue;
    const bool alone = radiances.size() == 2;
    const double middle =
        alone ? 0.5 * (radiances[0] + radiances[1]) : upper_median(std::move(radiances));
    for (const Seen& one : seen) {
      if (!bright(one, middle)) continue;
      const double off = std::abs(one.radiance - middle);
      differences[one.frame].push_back({off / std::sqrt(one.variance),
                                        off > changed_relative * std::abs(middle),
                                        alone ? 0.5 : 1.0});
    }
  }
  for (std::size_t j = 0; j < frames.size(); ++j) {
    if (!states[j] || differences[j].empty()) continue;
    // What all blocks differ by is the noise model's error (grain, scans), not a change.
    std::vector<double> sizes;
    for (const Difference& difference : differences[j]) sizes.push_back(difference.deviations);
    const double spread = std::max(1.0, upper_median(std::move(sizes)) / 0.6745);
    double changed = 0.0;
    for (const Difference& difference : differences[j]) {
      const bool beyond = difference.deviations > changed_deviations * spread && difference.large;
      changed += beyond ? difference.blame : 0.0;
    }
    states[j]->changed_share = changed / static_cast<double>(differences[j].size());
  }
}

template <class Reader, class Exposed, class Pixels>
Steadiness compare_stack(std::span<const Exposed> stack, const Radiometry& radiometry,
                         const Pixels& pixels) {
  Steadiness states(stack.size());
  if (stack.size() < 2) return states;
  const auto& shape = pixels(stack.front());
  if (shape.width() < smallest_frame_px || shape.height() < smallest_frame_px) return states;
  const int channel = shape.channels() / 2;
  const Reader reader(radiometry, channel);
  const auto c = static_cast<std::size_t>(channel);
  const NoiseModel noise(radiometry.response.linear[c], radiometry.noise[c], Reader::rounds);
  std::vector<std::size_t> order(stack.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return stack[a].exposure_s < stack[b].exposure_s;
  });
  std::vector<Blocks> blocks;
  for (const Exposed& frame : stack) {
    blocks.push_back(block_means<Reader>(pixels(frame), frame.exposure_s, reader, channel));
  }
  std::vector<std::size_t> chain{order.front()};
  std::vector<Pair> steps;
  const auto finish = [&] {
    if (!steps.empty()) place_chain(chain, steps, states);
    steps.clear();
  };
  for (std::size_t i = 1; i < order.size(); ++i) {
    const std::optional<Pair> pair = compare(blocks[order[i - 1]], blocks[order[i]], noise);
    if (pair) {
      steps.push_back(*pair);
      chain.push_back(order[i]);
    } else {
      finish();
      chain = {order[i]};
    }
  }
  finish();
  find_changes(blocks, noise, states);
  return states;
}

}  // namespace

Steadiness compare_frames(std::span<const ExposedFrame> stack, const Radiometry& radiometry) {
  return compare_stack<CodeReader>(
      stack, radiometry, [](const ExposedFrame& frame) -> const auto& { return frame.codes; });
}

Steadiness compare_frames(std::span<const ExposedFloatFrame> stack, const Radiometry& radiometry) {
  return compare_stack<FloatReader>(
      stack, radiometry,
      [](const ExposedFloatFrame& frame) -> const auto& { return frame.linear; });
}

}  // namespace kappamu::capture
