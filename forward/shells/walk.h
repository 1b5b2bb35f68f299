// The way of a ray through a hair texture, texel by texel (Amanatides and Woo 1987).
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "forward/shells/hair_texture.h"

namespace kappamu::forward::shells {

/// Calls visit(texel, length [texel]) along the ray from `point` until it returns false or the ray
/// leaves the volume. The volume repeats along x and y unless it stands `alone`.
template <class Visit>
void walk(const HairTexture& texture, const Eigen::Vector3d& point,
          const Eigen::Vector3d& direction, bool alone, const Visit& visit) {
  constexpr double endless = 4096.0;  // a horizontal ray through air ends after so many texels
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d edge(1.0, 1.0, texture.layer_height);
  const Eigen::Vector3d start = point.cwiseQuotient(edge), step = direction.cwiseQuotient(edge);
  const Eigen::Array3i size(texture.width, texture.width, texture.layers);
  Eigen::Array3i at, sense;
  Eigen::Array3d next, between;
  for (int i = 0; i < 3; ++i) {
    // On a texel's face a ray belongs to the texel that it goes into.
    at[i] = static_cast<int>(step[i] < 0.0 ? std::ceil(start[i]) - 1.0 : std::floor(start[i]));
    sense[i] = step[i] > 0.0 ? 1 : -1;
    const bool moves = std::abs(step[i]) > 1e-12;
    between[i] = moves ? 1.0 / std::abs(step[i]) : infinity;
    const double first = step[i] > 0.0 ? at[i] + 1.0 - start[i] : start[i] - at[i];
    next[i] = moves ? first * between[i] : infinity;
    if (i < 2 && !alone) at[i] = ((at[i] % size[i]) + size[i]) % size[i];
  }
  for (double travelled = 0.0; travelled < endless;) {
    if (at[2] < 0 || at[2] >= size[2]) return;
    if (alone && (at[0] < 0 || at[1] < 0 || at[0] >= size[0] || at[1] >= size[1])) return;
    int axis = 0;
    const double until = next.minCoeff(&axis);
    if (!visit(texture.texel(at[0], at[1], at[2]), until - travelled)) return;
    travelled = until;
    next[axis] += between[axis];
    at[axis] += sense[axis];
    if (axis == 2 || alone) continue;
    if (at[axis] == size[axis]) at[axis] = 0;
    if (at[axis] < 0) at[axis] = size[axis] - 1;
  }
}

}  // namespace kappamu::forward::shells
