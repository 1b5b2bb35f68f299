#include <algorithm>

#include "forward/grid/opencl/multigrid/cg_steps.h"

namespace kappamu::forward {

LaneSums::LaneSums(device::Context& context, const Format& format)
    : context_(context), format_(format) {}

void LaneSums::add_up(const LaneKernels& kernels, const device::Buffer& partial, std::size_t count,
                      const device::Buffer& sum) {
  constexpr std::size_t workgroup = 256;  // WORKGROUP in grid_vectors.cl
  context_.launch(kernels.common(), "sum_partials", {workgroup, 1, workgroup, 1},
                  static_cast<int>(count), partial, sum);
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
