#include "forward/dipole/hierarchy/profile_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/error.h"

namespace kappamu::forward::dipole {

ProfileTable tabulate(std::span<const Profile> profiles, double farthest) {
  check(!profiles.empty() && profiles.size() <= lanes, "a table holds one to four profiles");
  ProfileTable table;
  double smooth = profiles[0].smallest_depth();
  table.least_decay = static_cast<float>(profiles[0].decay());
  for (const Profile& profile : profiles) {
    table.least_decay = std::min(table.least_decay, static_cast<float>(profile.decay()));
    smooth = std::min(smooth, profile.smallest_depth());
    table.decay = std::max(table.decay, static_cast<float>(profile.decay()));
  }
  table.smooth = static_cast<float>(smooth);
  table.smooth2 = static_cast<float>(std::exp2(std::floor(2.0 * std::log2(smooth))));
  constexpr int shift = 23 - table_bits;
  const auto base = std::bit_cast<std::uint32_t>(table.smooth2);
  const auto last =
      std::bit_cast<std::uint32_t>(static_cast<float>(farthest * farthest) + table.smooth2);
  // One entry beyond the last interval.
  const std::size_t entries = ((last - base) >> shift) + 2;
  table.entries.resize(4 * entries);
  for (std::size_t i = 0; i < entries; ++i) {
    const auto u = std::bit_cast<float>(base + (static_cast<std::uint32_t>(i) << shift));
    const double r = std::sqrt(static_cast<double>(u - table.smooth2));
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const Profile& profile = profiles[std::min(lane, profiles.size() - 1)];
      const RadialDerivatives d = profile.derivatives(r);
      const std::array<double, 4> of{d.value, d.first, d.second, profile.beyond(r)};
      for (std::size_t what = 0; what < 4; ++what) {
        table.entries[4 * i + what][static_cast<Eigen::Index>(lane)] = static_cast<float>(of[what]);
      }
    }
  }
  return table;
}

}  // namespace kappamu::forward::dipole
