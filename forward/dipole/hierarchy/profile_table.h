// Up to four profiles as the device looks them up: R_d, R'/r, (R'/r)'/r and Φ over u = r² + z²,
// evenly spaced in each octave of u, linear in between (hierarchy.cl).
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "forward/dipole/profile/profile.h"

namespace kappamu::forward::dipole {

inline constexpr int table_bits = 5;  ///< 2^bits entries per octave: errors below 2e-3
inline constexpr std::size_t lanes = 4;

struct ProfileTable {
  float smooth2 = 0.0F;      ///< z² [mm²], a power of two not above the smallest depth squared
  float smooth = 0.0F;       ///< the smallest depth [mm]
  float decay = 0.0F;        ///< the largest σ_tr [1/mm]
  float least_decay = 0.0F;  ///< the smallest σ_tr [1/mm]
  std::vector<Eigen::Array4f> entries;  ///< four per entry, a profile per lane
};

/// For distances up to `farthest` [mm]. Fewer profiles than lanes: the last is repeated.
ProfileTable tabulate(std::span<const Profile> profiles, double farthest);

}  // namespace kappamu::forward::dipole
