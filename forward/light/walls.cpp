#include "forward/light/walls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/optics.h"

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

double Walls::transmitted(int /*wall*/, double cosine) const {
  return 1.0 - fresnel_internal(eta_, cosine);
}

MeshWalls::MeshWalls(const ObjectProblem& problem)
    : Walls(problem.eta),
      surface_(problem.surface),
      rays_(problem.rays),
      nudge_(nudge_share * bounding_box(problem.mesh).sizes().maxCoeff()) {}

Eigen::Vector3d MeshWalls::nudged(const Eigen::Vector3d& position, int triangle) const {
  const auto t = static_cast<std::size_t>(triangle);
  const Eigen::Vector3d to_middle = surface_.position[t] - position;
  const double way = to_middle.norm();
  const Eigen::Vector3d aside =
      way > nudge_ ? Eigen::Vector3d(nudge_ / way * to_middle) : to_middle;
  return position + aside - nudge_ * surface_.normal[t];
}

std::optional<RayHit> MeshWalls::off(const Eigen::Vector3d& position,
                                     const Eigen::Vector3d& direction, int triangle) const {
  const std::optional<RayHit> hit = rays_.first_hit(position, direction);
  if (!hit || hit->triangle != triangle) return hit;
  return rays_.first_hit(position, direction, hit->distance);
}

std::optional<RayHit> MeshWalls::inside(Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                                        int triangle) const {
  constexpr int tries = 4;
  for (int i = 0; i < tries; ++i) {
    const std::optional<RayHit> hit = off(position, direction, triangle);
    if (hit && normal(hit->triangle).dot(direction) > 0.0) return hit;
    position = nudged(position, triangle);
  }
  return std::nullopt;
}

std::optional<RayHit> MeshWalls::ahead(const Eigen::Vector3d& position,
                                       const Eigen::Vector3d& direction) const {
  const std::optional<RayHit> hit = rays_.first_hit(position, direction);
  const bool within = hit && hit->distance > nudge_ && normal(hit->triangle).dot(direction) > 0.0;
  return within ? hit : std::nullopt;
}

std::optional<RayHit> MeshWalls::outside(const Eigen::Vector3d& position,
                                         const Eigen::Vector3d& direction, int triangle) const {
  const std::optional<RayHit> hit = off(position, direction, triangle);
  // A wall from inside is rounding at an edge.
  return hit && normal(hit->triangle).dot(direction) < 0.0 ? hit : std::nullopt;
}

BoxWalls::BoxWalls(const GridShape& shape, double eta, const std::array<bool, 6>& open)
    : Walls(eta),
      far_(shape.voxel_mm * Eigen::Vector3d(shape.nx, shape.ny, shape.nz)),
      open_(open) {
  for (const Face face : all_faces) {
    Eigen::Vector3d& normal = normal_[static_cast<std::size_t>(face)] = Eigen::Vector3d::Zero();
    normal[axis_of(face)] = is_plus(face) ? 1.0 : -1.0;
  }
}

std::optional<RayHit> BoxWalls::inside(Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                                       int /*face*/) const {
  position = position.cwiseMax(Eigen::Vector3d::Zero()).cwiseMin(far_);
  RayHit hit;
  hit.distance = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double along = direction[axis];
    if (along == 0.0) continue;
    const double way = ((along > 0.0 ? far_[axis] : 0.0) - position[axis]) / along;
    if (way < hit.distance) {
      hit.distance = way;
      hit.triangle = 2 * axis + (along > 0.0 ? 1 : 0);
    }
  }
  return hit;
}

std::optional<RayHit> BoxWalls::ahead(const Eigen::Vector3d& position,
                                      const Eigen::Vector3d& direction) const {
  Eigen::Vector3d at = position;
  return inside(at, direction, 0);
}

double BoxWalls::transmitted(int face, double cosine) const {
  return open_[static_cast<std::size_t>(face)] ? Walls::transmitted(face, cosine) : 0.0;
}

}  // namespace kappamu::forward
