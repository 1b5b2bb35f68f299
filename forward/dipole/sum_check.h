// The error of a fast sum of the dipole, measured against the direct one at a few triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "forward/dipole/direct/direct_sum.h"

namespace kappamu::forward::dipole {

class SumCheck {
 public:
  /// Draws 32 triangles by `area`, the surface's own or 0 where it does not count, so that a mean
  /// over them is one over the surface. Keeps references to mesh and surface.
  SumCheck(const TriangleMesh& mesh, const Surface& surface, std::span<const double> area,
           std::uint64_t seed);

  std::size_t triangles() const { return checked_.size(); }
  /// The direct sum at these triangles.
  std::vector<double> exact(const Profile& profile, Placement placement,
                            std::span<const double> irradiance) const;
  /// Relative 2-norm error there of an exitance on all triangles; 1 where none of them is lit but
  /// others are.
  double error(std::span<const double> exact, std::span<const double> exitance) const;
  /// The same between two sums at these triangles; 0 where neither is lit.
  double difference(std::span<const double> exact, std::span<const double> other) const;

 private:
  const TriangleMesh& mesh_;
  const Surface& surface_;
  std::vector<std::size_t> checked_;
};

}  // namespace kappamu::forward::dipole
