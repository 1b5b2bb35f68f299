#include "forward/linear/lanes.h"

#include <algorithm>

namespace kappamu::forward::linear {

namespace {

constexpr std::size_t most_lanes = 8;

std::size_t width_for(std::size_t lights) {
  std::size_t width = 1;
  while (width < lights && width < most_lanes) width *= 2;
  return width;
}

}  // namespace

std::vector<Batch> batches_of(const std::vector<Load>& loads) {
  std::vector<std::vector<std::size_t>> of_channel;
  for (std::size_t l = 0; l < loads.size(); ++l) {
    of_channel.resize(std::max(of_channel.size(), loads[l].channel + 1));
    of_channel[loads[l].channel].push_back(l);
  }
  std::vector<Batch> batches;
  const bool one_each = std::all_of(of_channel.begin(), of_channel.end(),
                                    [](const auto& lights) { return lights.size() <= 1; });
  for (const std::vector<std::size_t>& lights : of_channel) {
    for (const std::size_t light : lights) {
      const bool joins =
          !batches.empty() && batches.back().lights.size() < most_lanes &&
          (one_each || loads[batches.back().lights[0]].channel == loads[light].channel);
      if (!joins) batches.emplace_back();
      Batch& batch = batches.back();
      batch.lights.push_back(light);
      if (one_each || batch.lanes.channels.empty()) {
        batch.lanes.channels.push_back(loads[light].channel);
      }
    }
  }
  for (Batch& batch : batches) batch.lanes.width = width_for(batch.lights.size());
  return batches;
}

}  // namespace kappamu::forward::linear
