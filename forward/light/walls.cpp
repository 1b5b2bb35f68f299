#include "forward/light/walls.h"

#include <algorithm>
#include <cmath>

namespace kappamu::forward {

namespace {

/// What a ray caster may need of the box's longest edge to tell a point from the surface.
constexpr double nudge_share = 1e-6;

}  // namespace

Eigen::Vector3d refracted(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                          double eta_ratio) {
  const double cosine = -direction.dot(normal);
  const double beyond =
      std::sqrt(std::max(0.0, 1.0 - eta_ratio * eta_ratio * (1.0 - cosine * cosine)));
  return (eta_ratio * direction + (eta_ratio * cosine - beyond) * normal).normalized();
}

Eigen::Vector3d mirrored(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal) {
  return (direction - 2.0 * normal.dot(direction) * normal).normalized();
}

Walls::Walls(const ObjectProblem& problem)
    : surface_(problem.surface),
      rays_(problem.rays),
      eta_(problem.eta),
      nudge_(nudge_share * bounding_box(problem.mesh).sizes().maxCoeff()) {}

Eigen::Vector3d Walls::nudged(const Eigen::Vector3d& position, int triangle) const {
  const auto t = static_cast<std::size_t>(triangle);
  const Eigen::Vector3d to_middle = surface_.position[t] - position;
  const double way = to_middle.norm();
  const Eigen::Vector3d aside =
      way > nudge_ ? Eigen::Vector3d(nudge_ / way * to_middle) : to_middle;
  return position + aside - nudge_ * surface_.normal[t];
}

std::optional<RayHit> Walls::off(const Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                                 int triangle) const {
  const std::optional<RayHit> hit = rays_.first_hit(position, direction);
  if (!hit || hit->triangle != triangle) return hit;
  return rays_.first_hit(position, direction, hit->distance);
}

std::optional<RayHit> Walls::inside(Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                                    int triangle) const {
  constexpr int tries = 4;
  for (int i = 0; i < tries; ++i) {
    const std::optional<RayHit> hit = off(position, direction, triangle);
    if (hit && normal(hit->triangle).dot(direction) > 0.0) return hit;
    position = nudged(position, triangle);
  }
  return std::nullopt;
}

std::optional<RayHit> Walls::outside(const Eigen::Vector3d& position,
                                     const Eigen::Vector3d& direction, int triangle) const {
  const std::optional<RayHit> hit = off(position, direction, triangle);
  // A wall from inside is rounding at an edge.
  return hit && normal(hit->triangle).dot(direction) < 0.0 ? hit : std::nullopt;
}

}  // namespace kappamu::forward
