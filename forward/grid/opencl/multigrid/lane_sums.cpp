#include <algorithm>

#include "forward/grid/opencl/multigrid/cg_steps.h"

namespace kappamu::forward {

namespace {
constexpr std::size_t most_stripes = 64;
/// Up to this many partial sums are added in one go.
constexpr std::size_t few_partials = 512;
}  // namespace

LaneSums::LaneSums(device::Context& context, const Format& format, int lanes)
    : context_(context),
      format_(format),
      stripes_(
          context.allocate(most_stripes * static_cast<std::size_t>(lanes) * format.accu_bytes())) {}

void LaneSums::add_up(const LaneKernels& kernels, const device::Buffer& partial, std::size_t count,
                      const device::Buffer& sum) {
  const auto add = [&](std::size_t from, std::size_t to, const device::Buffer& in,
                       const device::Buffer& out) {
    context_.launch(kernels.vectors(), "sum_stripes", kernels.items(to), static_cast<int>(from),
                    static_cast<int>(to), in, out);
  };
  if (count <= few_partials) {
    add(count, 1, partial, sum);
  } else {
    add(count, most_stripes, partial, stripes_);
    add(most_stripes, 1, stripes_, sum);
  }
}

LaneScalars LaneSums::read(const LaneKernels& kernels, const device::Buffer& values,
                           std::size_t count) {
  const std::size_t size = static_cast<std::size_t>(kernels.lanes()) * count;
  LaneScalars result(size);
  if (format_.accurate_sums) {
    context_.read(values, result.data(), size * sizeof(double));
    return result;
  }
  std::vector<float> rounded(size);
  context_.read(values, rounded.data(), size * sizeof(float));
  std::copy(rounded.begin(), rounded.end(), result.begin());
  return result;
}

}  // namespace kappamu::forward
