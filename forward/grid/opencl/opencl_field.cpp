#include "forward/grid/opencl/opencl_field.h"

#include <algorithm>

#include "core/parallel.h"

namespace kappamu::forward {

namespace {

/// Samples a thread packs at once: what it then holds of all lanes stays in its cache.
constexpr std::size_t samples_at_once = 1024;

template <class Real>
void write_as(device::Context& context, const Block& block, std::size_t samples,
              std::span<const double> values) {
  const auto lanes = static_cast<std::size_t>(block.lanes);
  std::vector<Real> packed(samples * lanes, Real{0});
  for_pieces(samples, samples_at_once, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (int m = 0; m < block.count; ++m) {
      const double* from = values.data() + static_cast<std::size_t>(block.first + m) * samples;
      Real* to = packed.data() + m;
      for (std::size_t i = begin; i < end; ++i) to[i * lanes] = static_cast<Real>(from[i]);
    }
  });
  context.write(block.values, packed.data(), packed.size() * sizeof(Real));
}

template <class Real>
void read_as(device::Context& context, const Block& block, std::size_t samples,
             std::span<double> values) {
  const auto lanes = static_cast<std::size_t>(block.lanes);
  std::vector<Real> packed(samples * lanes);
  context.read(block.values, packed.data(), packed.size() * sizeof(Real));
  for_pieces(samples, samples_at_once, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (int m = 0; m < block.count; ++m) {
      double* to = values.data() + static_cast<std::size_t>(block.first + m) * samples;
      const Real* from = packed.data() + m;
      for (std::size_t i = begin; i < end; ++i) to[i] = static_cast<double>(from[i * lanes]);
    }
  });
}

}  // namespace

std::vector<Block> cut_into_blocks(int patterns, int most) {
  std::vector<Block> blocks;
  for (int first = 0; first < patterns;) {
    const int left = patterns - first;
    const int wanted = left > 8 ? 16 : left > 4 ? 8 : left > 1 ? 4 : 1;
    Block block;
    block.first = first;
    block.lanes = std::min(wanted, most);
    block.count = std::min(left, block.lanes);
    first += block.count;
    blocks.push_back(block);
  }
  return blocks;
}

void write_block(device::Context& context, const Format& format, const Block& block,
                 std::size_t samples, std::span<const double> values) {
  if (format.single) {
    write_as<float>(context, block, samples, values);
  } else {
    write_as<double>(context, block, samples, values);
  }
}

void read_block(device::Context& context, const Format& format, const Block& block,
                std::size_t samples, std::span<double> values) {
  if (format.single) {
    read_as<float>(context, block, samples, values);
  } else {
    read_as<double>(context, block, samples, values);
  }
}

}  // namespace kappamu::forward
