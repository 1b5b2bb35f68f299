// A batch of patterns on an OpenCL device: blocks of 16, 8, 4 or 1 lanes, patterns innermost.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "device/context.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"

namespace kappamu::forward {

/// `count` patterns from `first` on, in a buffer of `lanes` ≥ count; the lanes beyond are zero.
struct Block {
  int first = 0;
  int count = 0;
  int lanes = 1;
  device::Buffer values;  ///< [cell][lane]
};

struct OpenclField final : BatchField {
  int patterns() const override { return total; }
  int total = 0;
  bool zero = false;  ///< known to be, whatever the blocks hold
  std::vector<Block> blocks;
};

/// Samples of a face for the patterns of a block, in its lanes.
using SamplesOf = std::function<device::Buffer(const Block& block)>;

/// Cuts a batch into blocks of at most `most` lanes (16, 8, 4 or 1), with few lanes wasted; buffers
/// are left empty.
std::vector<Block> cut_into_blocks(int patterns, int most);

/// Between host [pattern][sample] in double and one block's [sample][lane] on the device.
void write_block(device::Context& context, const Format& format, const Block& block,
                 std::size_t samples, std::span<const double> values);
void read_block(device::Context& context, const Format& format, const Block& block,
                std::size_t samples, std::span<double> values);

}  // namespace kappamu::forward
