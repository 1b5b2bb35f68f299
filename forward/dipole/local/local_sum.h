// The dipole's surface integral by samples about each point ([T] 3.4): importance samples of R_d in
// the tangent plane, projected on the surface, together with samples of the light, weighted by the
// balance heuristic (Veach 1997, 9.2).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "forward/dipole/profile/profile.h"
#include "forward/object_model.h"

namespace kappamu::forward::dipole {

/// How many samples of each kind a point takes.
struct SampleCounts {
  int importance = 0;  ///< distance by R_d in the tangent plane, projected on the surface
  int light = 0;       ///< by the power that enters, over the whole surface
  int uniform = 0;     ///< by area, over the whole surface

  int all() const { return importance + light + uniform; }
};

/// Samples in the tangent plane are projected
/// - along the normal, on every part of the surface that the line meets: unbiased everywhere; or
/// - towards an eye, on the part that it sees ([T] 3.26): what entered elsewhere is missing.
class LocalSum {
 public:
  /// Keeps references to all, and to the problem's mesh, surface and rays. `irradiance`: W/mm²
  /// after the surface, per triangle.
  LocalSum(const ObjectProblem& problem, const Profile& profile,
           std::span<const double> irradiance);

  /// Exitance at the triangle's centroid. Points are of low discrepancy within a key, and
  /// independent between keys.
  double exitance(std::size_t triangle, const SampleCounts& counts, std::uint64_t key) const;
  /// The same in image space: `eye` [mm] in the object's frame.
  double exitance_seen(std::size_t triangle, const SampleCounts& counts, std::uint64_t key,
                       const Eigen::Vector3d& eye) const;

 private:
  struct Receiver;
  struct Sample;

  double sum(const Receiver& receiver, const SampleCounts& counts, std::uint64_t key) const;
  void project(const Receiver& receiver, const Eigen::Vector3d& in_plane,
               std::vector<Sample>& samples) const;
  /// Samples per area that all kinds together put at a point.
  double density(const Receiver& receiver, const Sample& sample, const SampleCounts& counts) const;
  Sample drawn(const std::vector<double>& cumulative, std::uint32_t index, std::uint64_t key) const;

  const ObjectProblem& problem_;
  const Profile& profile_;
  std::span<const double> irradiance_;
  std::vector<double> power_, area_;  ///< sums over the triangles up to each [mm²]
  double reflectance_ = 0.0, diameter_ = 0.0;
};

/// Which triangles' centroids the eye sees; `eye` [mm] in the object's frame.
std::vector<bool> seen_from(const ObjectProblem& problem, const Eigen::Vector3d& eye);

}  // namespace kappamu::forward::dipole
