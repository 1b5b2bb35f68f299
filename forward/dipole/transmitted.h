// What a light brings through the surface, as the dipole takes it.
#pragma once

#include <vector>

#include "forward/object_model.h"

namespace kappamu::forward::dipole {

/// E_η of [T] 3.7 on every triangle, W/mm² after the surface. A beam counts for the triangle it
/// meets. Throws InputError for a beam from inside.
std::vector<double> transmitted(const Surface& surface, double eta, const ObjectLight& light);

}  // namespace kappamu::forward::dipole
