// Exact importance sampling of the dipole's profile over the plane, by inversion ([T] 3.4.1).
#pragma once

#include "forward/dipole/profile/profile.h"

namespace kappamu::forward::dipole {

/// Of `u`, uniform in [0, 1): a distance r with density 2π R_d(r) r/ρ, ρ the profile's reflectance.
/// A term is picked by its share, and σz(w − 1) + log w + log(1 − u) = 0, w = √(1 + (r/z)²), solved
/// ([T] 3.25). Every term must give exitance by flux alone, as the classical dipole's do.
double sampled_radius(const Profile& profile, double u);

}  // namespace kappamu::forward::dipole
