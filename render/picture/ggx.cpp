#include "render/picture/ggx.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/optics.h"

namespace kappamu::render {

using Eigen::Vector3d;

/// D [1/sr] of a facet whose normal has this cosine (Walter 2007, 33).
double Ggx::facets(double cosine) const {
  const double a2 = alpha_ * alpha_;
  const double t = cosine * cosine * (a2 - 1.0) + 1.0;
  return a2 / (std::numbers::pi * t * t);
}

/// Λ of Smith's masking (Heitz 2014, 72).
double Ggx::lambda(double cosine) const {
  const double tan2 = 1.0 / (cosine * cosine) - 1.0;
  return 0.5 * (std::sqrt(1.0 + alpha_ * alpha_ * tan2) - 1.0);
}

double Ggx::reflectance(const Vector3d& view, const Vector3d& light) const {
  if (view.z() <= 0.0 || light.z() <= 0.0) return 0.0;
  const Vector3d half = (view + light).normalized();
  const double masking = 1.0 / (1.0 + lambda(view.z()) + lambda(light.z()));
  return fresnel_external(eta_, std::min(1.0, half.dot(light))) * facets(half.z()) * masking /
         (4.0 * view.z());
}

Vector3d Ggx::sample(const Vector3d& view, double u, double v) const {
  if (mirror()) return {-view.x(), -view.y(), view.z()};
  // In the frame where facets are a hemisphere, seen along `stretched` (Heitz 2018, listing 1).
  const Vector3d stretched = Vector3d(alpha_ * view.x(), alpha_ * view.y(), view.z()).normalized();
  const double across = std::hypot(stretched.x(), stretched.y());
  const Vector3d first = across > 0.0
                             ? Vector3d(-stretched.y() / across, stretched.x() / across, 0.0)
                             : Vector3d::UnitX();
  const Vector3d second = stretched.cross(first);
  const double radius = std::sqrt(u), angle = 2.0 * std::numbers::pi * v;
  const double x = radius * std::cos(angle);
  const double blend = 0.5 * (1.0 + stretched.z());
  const double y =
      (1.0 - blend) * std::sqrt(std::max(0.0, 1.0 - x * x)) + blend * radius * std::sin(angle);
  const Vector3d visible =
      x * first + y * second + std::sqrt(std::max(0.0, 1.0 - x * x - y * y)) * stretched;
  const Vector3d facet =
      Vector3d(alpha_ * visible.x(), alpha_ * visible.y(), std::max(1e-12, visible.z()))
          .normalized();
  return 2.0 * view.dot(facet) * facet - view;
}

double Ggx::density(const Vector3d& view, const Vector3d& light) const {
  if (view.z() <= 0.0 || light.z() <= 0.0) return 0.0;
  const Vector3d half = (view + light).normalized();
  // Visible facets G₁ D max(0, v·h)/cosθ_v, by the Jacobian 1/(4 v·h) of the reflection.
  return facets(half.z()) / ((1.0 + lambda(view.z())) * 4.0 * view.z());
}

}  // namespace kappamu::render
