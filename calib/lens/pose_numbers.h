// A pose as six numbers, rotation vector and translation, and back.
#pragma once

#include <array>

#include "core/rigid.h"

namespace kappamu::calib {

std::array<double, 6> six_of(const Rigid& motion);
Rigid rigid_of(const std::array<double, 6>& six);

}  // namespace kappamu::calib
