#include "capture/radiance/steadiness.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/radiance/frame_pair.h"
#include "capture/response/frame_reader.h"
#include "core/numbers/median.h"
#include "core/parallel.h"

namespace kappamu::capture {
namespace {

constexpr int smallest_frame_px = 3 * block_px;
// Blocks nearer to saturation than this are left out: some of their pixels are cut.
constexpr float near_saturation = 0.9F;
constexpr double changed_deviations = 6.0;
constexpr double changed_relative = 0.1;
constexpr double shifted_px = 0.1;

// So many blocks determine gain and shift far below their tolerances. Of larger pictures those on a
// lattice of at least as many are looked at, and the four beside each, for its gradient.
constexpr int most_blocks = 40'000;

int lattice_step(int across, int down) {
  return std::max(1, static_cast<int>(std::sqrt(1.0 * across * down / most_blocks)));
}

bool looked_at(int block_x, int block_y, int step) {
  const auto off = [step](int at) { return std::min(at % step, step - at % step); };
  return off(block_x) + off(block_y) <= 1;
}

// The blocks' grid lies `offset` px off the frame's corner.
template <class Value>
Blocks block_means(const Exposed<Value>& frame, const FrameReader<Value>& reader, int channel,
                   const Eigen::Vector2i& offset = Eigen::Vector2i::Zero()) {
  const Image<Value>& image = frame.pixels;
  Blocks blocks{image.width() / block_px, image.height() / block_px, frame.exposure_s, {}};
  blocks.signal.assign(
      static_cast<std::size_t>(blocks.columns) * static_cast<std::size_t>(blocks.rows),
      std::nanf(""));
  const float limit = near_saturation * reader.saturation();
  const int step = lattice_step(blocks.columns, blocks.rows);
  for (int row = 0; row < blocks.rows; ++row) {
    for (int column = 0; column < blocks.columns; ++column) {
      const int top = row * block_px + offset.y();
      const int left = column * block_px + offset.x();
      if (!looked_at(column, row, step) || top < 0 || left < 0 || top + block_px > image.height() ||
          left + block_px > image.width()) {
        continue;
      }
      float sum = 0.0F;
      bool saturated = false;
      for (int y = top; y < top + block_px; ++y) {
        for (int x = left; x < left + block_px; ++x) {
          const auto value = image(x, y, channel);
          saturated |= reader.saturated(value);
          sum += reader.linear(value);
        }
      }
      const float mean = sum / static_cast<float>(block_pixels);
      if (saturated || mean > limit) continue;
      blocks.signal[static_cast<std::size_t>(row) * static_cast<std::size_t>(blocks.columns) +
                    static_cast<std::size_t>(column)] = mean;
    }
  }
  return blocks;
}

// Places the frames of a chain of comparable neighbours relative to the chain's median.
void place_chain(const std::vector<std::size_t>& chain, const std::vector<FramePair>& steps,
                 Steadiness& states) {
  std::vector<double> gains{0.0};
  std::vector<double> x{0.0};
  std::vector<double> y{0.0};
  for (const FramePair& step : steps) {
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
// differ everywhere, and that is reported already.
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
  std::vector<std::size_t> compared;
  std::vector<double> times(frames.size());
  for (std::size_t j = 0; j < frames.size(); ++j) {
    if (!states[j] || states[j]->blank ||
        std::hypot(states[j]->shift_px[0], states[j]->shift_px[1]) > shifted_px)
      continue;
    compared.push_back(j);
    times[j] = frames[j].exposure_s * std::exp(states[j]->log_gain);
  }
  std::vector<std::vector<Difference>> differences(frames.size());
  std::vector<Seen> seen;
  std::vector<double> radiances;
  for (std::size_t i = 0; i < frames.front().signal.size(); ++i) {
    seen.clear();
    radiances.clear();
    for (const std::size_t j : compared) {
      const float signal = frames[j].signal[i];
      if (!std::isfinite(signal)) continue;
      const double time = times[j];
      seen.push_back({j, signal / time, noise.variance(signal) / block_pixels / (time * time)});
    }
    // Pixels near black may be cut off there: a frame has its say where its pixels stand well above
    // their noise, and is checked where the others promise that.
    const auto bright = [&](const Seen& one, double radiance) {
      const double signal = radiance * times[one.frame];
      return signal > least_signal_to_noise * std::sqrt(noise.variance(signal));
    };
    for (const Seen& one : seen) {
      if (bright(one, one.radiance)) radiances.push_back(one.radiance);
    }
    if (radiances.size() < 2) continue;
    const bool alone = radiances.size() == 2;
    const double middle = alone ? 0.5 * (radiances[0] + radiances[1]) : upper_median(radiances);
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

template <class Value>
Steadiness compare_stack(std::span<const Exposed<Value>> stack, const Radiometry& radiometry) {
  using Reader = FrameReader<Value>;
  Steadiness states(stack.size());
  if (stack.size() < 2) return states;
  const Image<Value>& shape = stack.front().pixels;
  if (shape.width() < smallest_frame_px || shape.height() < smallest_frame_px) return states;
  const int channel = shape.channels() / 2;
  const Reader reader(radiometry, channel);
  const auto c = static_cast<std::size_t>(channel);
  const NoiseModel noise(radiometry.response.linear[c], radiometry.noise[c], Reader::rounding);
  std::vector<std::size_t> order(stack.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return stack[a].exposure_s < stack[b].exposure_s;
  });
  std::vector<Blocks> blocks(stack.size());
  for_rows(static_cast<int>(stack.size()), [&](int j) {
    const auto frame = static_cast<std::size_t>(j);
    blocks[frame] = block_means(stack[frame], reader, channel);
  });
  std::vector<std::size_t> chain{order.front()};
  std::vector<FramePair> steps;
  const auto finish = [&] {
    if (!steps.empty()) place_chain(chain, steps, states);
    steps.clear();
  };
  for (std::size_t i = 1; i < order.size(); ++i) {
    const auto longer_at = [&](const Eigen::Vector2i& offset) {
      return offset.isZero() ? blocks[order[i]]
                             : block_means(stack[order[i]], reader, channel, offset);
    };
    const Blocks& shorter = blocks[chain.back()];
    const std::optional<FramePair> pair = compare_pair(shorter, longer_at, noise);
    if (pair) {
      steps.push_back(*pair);
      chain.push_back(order[i]);
    } else if (is_blank(blocks[order[i]], shorter, noise)) {
      states[order[i]].emplace().blank = true;  // and the next is compared with the one before
    } else {
      if (is_blank(shorter, blocks[order[i]], noise)) states[chain.back()].emplace().blank = true;
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
  return compare_stack(stack, radiometry);
}

Steadiness compare_frames(std::span<const ExposedFloatFrame> stack, const Radiometry& radiometry) {
  return compare_stack(stack, radiometry);
}

}  // namespace kappamu::capture
