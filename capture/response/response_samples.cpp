// Choice of the blocks from which the response is recovered.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "capture/response/response.h"

namespace kappamu::capture {
namespace {

constexpr int code_bins = 32;
constexpr std::size_t blocks_per_code_bin = 8;  // the smoothest of each frame

// Blocks with a code from here on are not used. Eight-bit files come out of a camera's own
// processing, which bends the codes below clipping; deeper ones are true to their last codes, and
// the curve's end, where it is normalised, needs them.
int clipping_code(int bit_depth) {
  const int top = (1 << bit_depth) - 1;
  return bit_depth > 8 ? static_cast<int>(0.998 * top) : saturation_code(bit_depth);
}

struct BlockStatistics {
  float mean = 0.0F;
  float variance = 0.0F;
  bool saturated = false;
};

// [block] of one frame and channel; blocks in rows, what is left at the right and bottom unused.
std::vector<BlockStatistics> block_statistics(const Image<std::uint16_t>& codes, int channel,
                                              int saturated_from) {
  constexpr int edge = sample_block_px;
  const int columns = codes.width() / edge;
  const int rows = codes.height() / edge;
  std::vector<BlockStatistics> blocks;
  blocks.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const double count = edge * edge;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      std::int64_t sum = 0;
      std::int64_t sum_of_squares = 0;
      int largest = 0;
      for (int y = row * edge; y < (row + 1) * edge; ++y) {
        for (int x = column * edge; x < (column + 1) * edge; ++x) {
          const std::int64_t code = codes(x, y, channel);
          sum += code;
          sum_of_squares += code * code;
          largest = std::max(largest, static_cast<int>(code));
        }
      }
      const double mean = static_cast<double>(sum) / count;
      const double variance =
          (static_cast<double>(sum_of_squares) - static_cast<double>(sum) * mean) / (count - 1.0);
      blocks.push_back({static_cast<float>(mean), static_cast<float>(std::max(variance, 0.0)),
                        largest >= saturated_from});
    }
  }
  return blocks;
}

}  // namespace

int saturation_code(int bit_depth) {
  const int top = (1 << bit_depth) - 1;
  return static_cast<int>(std::ceil(0.99 * top));
}

int saturation_code(const std::vector<double>& linear) {
  const auto white = std::find_if(linear.begin(), linear.end(), [](double x) { return x >= 1.0; });
  const auto top = std::min<std::ptrdiff_t>(white - linear.begin(), std::ssize(linear) - 1);
  return static_cast<int>(std::ceil(0.99 * static_cast<double>(top)));
}

void collect_response_samples(std::span<const ExposedFrame> stack, int channel, int bit_depth,
                              std::vector<ResponseSample>& samples) {
  if (stack.empty()) return;
  std::vector<std::vector<BlockStatistics>> blocks;  // [frame][block]
  for (const ExposedFrame& frame : stack) {
    blocks.push_back(block_statistics(frame.pixels, channel, clipping_code(bit_depth)));
  }
  // For each frame and code bin the blocks whose codes vary least.
  const std::size_t block_count = blocks.front().size();
  const double codes_per_bin = std::ldexp(1.0, bit_depth) / code_bins;
  std::vector<std::uint8_t> chosen(block_count, 0);
  for (const std::vector<BlockStatistics>& frame : blocks) {
    std::vector<std::vector<std::pair<float, std::size_t>>> bins(code_bins);
    for (std::size_t block = 0; block < block_count; ++block) {
      if (frame[block].saturated) continue;
      const auto bin = static_cast<std::size_t>(frame[block].mean / codes_per_bin);
      bins[std::min<std::size_t>(bin, code_bins - 1)].emplace_back(frame[block].variance, block);
    }
    for (auto& bin : bins) {
      const auto keep = std::min<std::size_t>(bin.size(), blocks_per_code_bin);
      std::partial_sort(bin.begin(), bin.begin() + static_cast<std::ptrdiff_t>(keep), bin.end());
      for (std::size_t i = 0; i < keep; ++i) chosen[bin[i].second] = 1;
    }
  }
  for (std::size_t block = 0; block < block_count; ++block) {
    if (chosen[block] == 0) continue;
    ResponseSample sample;
    for (std::size_t j = 0; j < stack.size(); ++j) {
      const BlockStatistics& statistics = blocks[j][block];
      sample.code.push_back(statistics.mean);
      sample.variance.push_back(statistics.variance);
      sample.log_exposure.push_back(std::log(stack[j].exposure_s));
      sample.valid.push_back(statistics.saturated ? 0 : 1);
    }
    samples.push_back(std::move(sample));
  }
}

}  // namespace kappamu::capture
