#include "studies/forward/bandwidth.h"

#include <algorithm>
#include <vector>

#include "core/processor_time.h"

namespace kappamu::studies {

extern const device::KernelSource bandwidth_cl;

double measured_copy_bandwidth(device::Context& context) {
  const device::DeviceInfo& info = context.info();
  const bool gpu = info.kind == device::Kind::gpu;
  const std::size_t step = (gpu ? 4 : 16) * sizeof(float);
  // Several times the last cache, and on a GPU long enough to hide what starting a kernel takes.
  const std::size_t wanted = (gpu ? std::size_t{1024} : std::size_t{256}) << 20;
  const std::size_t bytes =
      std::min({wanted, info.max_allocation_bytes, info.global_memory_bytes / 8}) / step * step;
  const int count = static_cast<int>(bytes / step);
  const device::Buffer from = context.allocate(bytes), to = context.allocate(bytes);
  // Pages never written may all be one page of zeros, which reads like a cache.
  const std::vector<float> values(bytes / sizeof(float), 1.0F);
  context.write(from, values.data(), bytes);
  context.write(to, values.data(), bytes);
  device::Program& program =
      context.program(bandwidth_cl, gpu ? "-DINTERLEAVED=1" : "-DINTERLEAVED=0");
  const std::size_t units = std::max(1U, info.compute_units);
  const device::Range items =
      gpu ? device::Range{units * 2048, 1, 256, 1} : device::Range{units * 4, 1, 1, 1};
  constexpr int repetitions = 6;
  double best = 0.0;
  for (const char* kernel : {"copy", "copy_past_cache"}) {
    for (int k = 0; k < repetitions; ++k) {
      context.finish();
      const Stopwatch watch;
      context.launch(program, kernel, items, count, from, to);
      context.finish();
      best = std::max(best, 2.0 * static_cast<double>(bytes) / watch.seconds());
    }
  }
  return best;
}

}  // namespace kappamu::studies
