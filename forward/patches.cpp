#include "forward/patches.h"

#include <array>
#include <cmath>
#include <map>

namespace kappamu::forward {

Patches make_patches(const Surface& surface, const Eigen::AlignedBox3d& box, int cells) {
  const double edge = box.sizes().maxCoeff() / cells;
  std::map<std::array<int, 4>, int> known;
  Patches patches;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    std::array<int, 4> key{};
    const Eigen::Vector3d at = (surface.position[i] - box.min()) / edge;
    for (int axis = 0; axis < 3; ++axis) {
      key[static_cast<std::size_t>(axis)] =
          std::min(cells - 1, static_cast<int>(std::floor(at[axis])));
    }
    int axis = 0;
    surface.normal[i].cwiseAbs().maxCoeff(&axis);
    key[3] = 2 * axis + (surface.normal[i][axis] > 0.0 ? 1 : 0);
    const auto [entry, fresh] = known.try_emplace(key, static_cast<int>(patches.area.size()));
    if (fresh) patches.area.push_back(0.0);
    patches.of_sample.push_back(entry->second);
    patches.area[static_cast<std::size_t>(entry->second)] += surface.area[i];
  }
  return patches;
}

std::vector<double> Patches::mean(const std::vector<double>& samples,
                                  const Surface& surface) const {
  std::vector<double> result(size(), 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto p = static_cast<std::size_t>(of_sample[i]);
    result[p] += surface.area[i] / area[p] * samples[i];
  }
  return result;
}

std::vector<double> Patches::error_of_mean(const std::vector<double>& samples,
                                           const std::vector<double>& standard_error,
                                           const Surface& surface) const {
  std::vector<double> result(size(), 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i] <= 0.0) continue;
    const auto p = static_cast<std::size_t>(of_sample[i]);
    const double part = surface.area[i] / area[p] * standard_error[i];
    result[p] += part * part;
  }
  for (double& error : result) error = std::sqrt(error);
  return result;
}

}  // namespace kappamu::forward
