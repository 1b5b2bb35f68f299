// The way of a ray through a hair texture, texel by texel (Amanatides and Woo 1987).
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "forward/shells/hair_texture.h"

namespace kappamu::forward::shells {

/// A ray's progress along one axis, in texels of that axis.
struct AxisWalk {
  AxisWalk(double start, double step) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    // On a texel's face a ray belongs to the texel that it goes into.
    at = static_cast<int>(step < 0.0 ? std::ceil(start) - 1.0 : std::floor(start));
    sense = step > 0.0 ? 1 : -1;
    if (std::abs(step) <= 1e-12) {
      next = between = infinity;
      return;
    }
    between = 1.0 / std::abs(step);
    next = (step > 0.0 ? at + 1.0 - start : start - at) * between;
  }
  void wrap(int size) { at = ((at % size) + size) % size; }
  void go() {
    next += between;
    at += sense;
  }
  void go_wrapping(int size) {
    go();
    if (at == size) at = 0;
    if (at < 0) at = size - 1;
  }

  int at = 0, sense = 1;
  double next = 0.0, between = 0.0;  ///< way to the next face, and from face to face
};

/// Calls visit(texel, length [texel]) along the ray from `point` until it returns false or the ray
/// leaves the volume. The volume repeats along x and y unless it stands `alone`.
template <class Visit>
void walk(const HairTexture& texture, const Eigen::Vector3d& point,
          const Eigen::Vector3d& direction, bool alone, const Visit& visit) {
  constexpr double endless = 4096.0;  // a horizontal ray through air ends after so many texels
  AxisWalk x(point.x(), direction.x()), y(point.y(), direction.y()),
      z(point.z() / texture.layer_height, direction.z() / texture.layer_height);
  const int size = texture.width;
  if (!alone) {
    x.wrap(size);
    y.wrap(size);
  }
  const auto beside = [size](const AxisWalk& axis) { return axis.at < 0 || axis.at >= size; };
  for (double travelled = 0.0; travelled < endless;) {
    if (z.at < 0 || z.at >= texture.layers) return;
    if (alone && (beside(x) || beside(y))) return;
    const std::size_t texel = texture.texel(x.at, y.at, z.at);
    AxisWalk& first = x.next < y.next ? (x.next < z.next ? x : z) : (y.next < z.next ? y : z);
    const double until = first.next;
    if (!visit(texel, until - travelled)) return;
    travelled = until;
    if (alone || &first == &z) {
      first.go();
    } else {
      first.go_wrapping(size);
    }
  }
}

}  // namespace kappamu::forward::shells
