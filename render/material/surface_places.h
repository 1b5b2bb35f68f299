// The places of points in a body: depth below the surface and the closest point of it.
#pragma once

#include "core/mesh/triangle_mesh.h"
#include "forward/polygrid/closest_point.h"
#include "render/material/material_field.h"

namespace kappamu::render {

class SurfacePlaces {
 public:
  /// The mesh outlives it.
  explicit SurfacePlaces(const TriangleMesh& mesh) : mesh_(mesh), closest_(mesh) {}

  /// `near`: a triangle to look at first, for speed alone. `outside` [mm]: distance of a point
  /// outside, negative inside.
  Place at(const Eigen::Vector3d& point, int near, double& outside) const;

 private:
  const TriangleMesh& mesh_;
  forward::ClosestPoint closest_;
};

}  // namespace kappamu::render
