#include "inverse/problem/on_device/device_data.h"

#include <algorithm>
#include <numeric>

#include "core/error.h"

namespace kappamu::inverse {

DeviceData::DeviceData(device::Context& context, const std::vector<double>& light, int lights,
                       int at_once, std::size_t exitance_size)
    : arithmetic_(context) {
  const std::size_t light_size = light.size() / static_cast<std::size_t>(lights);
  const double* next = light.data();
  for (int first = 0; first < lights; first += at_once) {
    const auto patterns = static_cast<std::size_t>(std::min(at_once, lights - first));
    Batch& batch = batches_.emplace_back();
    batch.values = patterns * exitance_size;
    batch.light = arithmetic_.take(patterns * light_size);
    batch.exitance = arithmetic_.take(batch.values);
    batch.by_exitance = arithmetic_.take(batch.values);
    context.write(batch.light, next, patterns * light_size * sizeof(double));
    next += patterns * light_size;
  }
}

void DeviceData::write(device::Buffer Batch::*where, const std::vector<double>& values) {
  const double* next = values.data();
  for (Batch& batch : batches_) {
    if (!(batch.*where)) batch.*where = arithmetic_.take(batch.values);
    arithmetic_.context().write(batch.*where, next, batch.values * sizeof(double));
    next += batch.values;
  }
  check(next == values.data() + values.size(), "values do not fit the exitance");
}

void DeviceData::set_data(const std::vector<double>& data, const std::vector<double>& weight,
                          const std::vector<double>& ratio) {
  write(&Batch::data, data);
  write(&Batch::weight, weight);
  write(&Batch::ratio, ratio);
}

double DeviceData::misfit() {
  const device::Buffer sums = arithmetic_.take(batches_.size());
  for (std::size_t k = 0; k < batches_.size(); ++k) {
    const Batch& batch = batches_[k];
    arithmetic_.reduce_into(sums, k, "gaussian_misfit", batch.values, 1, 0,
                            static_cast<int>(batch.values), batch.exitance, batch.ratio, batch.data,
                            batch.weight, batch.by_exitance);
  }
  const std::vector<double> of_batches = arithmetic_.read(sums, batches_.size());
  return std::accumulate(of_batches.begin(), of_batches.end(), 0.0);
}

device::Buffer DeviceData::zeros(std::size_t doubles) {
  device::Buffer buffer = arithmetic_.take(doubles);
  arithmetic_.context().zero(buffer, doubles * sizeof(double));
  return buffer;
}

std::vector<double> DeviceData::exitance() const {
  std::vector<double> all;
  for (const Batch& batch : batches_) {
    const std::vector<double> part = arithmetic_.read(batch.exitance, batch.values);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

void DeviceData::set_by_exitance(const std::vector<double>& values) {
  write(&Batch::by_exitance, values);
}

}  // namespace kappamu::inverse
