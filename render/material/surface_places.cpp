#include "render/material/surface_places.h"

#include <algorithm>

namespace kappamu::render {

Place SurfacePlaces::at(const Eigen::Vector3d& point, int near, double& outside) const {
  const auto found = closest_.from(point, near);
  Place place;
  place.point = point;
  place.surface = found.point;
  place.normal = closest_.smooth_normal(found);
  place.triangle = found.triangle;
  place.weights = found.weights;
  // On an edge or a corner, the face's own normal does not tell sides apart (Bærentzen, Aanæs
  // 2005).
  const bool on_edge = found.weights.minCoeff() <= 0.0;
  const Eigen::Vector3d& facing = on_edge ? place.normal : closest_.normal(found.triangle);
  outside = (point - found.point).dot(facing) > 0.0 ? found.distance : -found.distance;
  place.depth = std::max(0.0, -outside);
  return place;
}

}  // namespace kappamu::render
