#include "calib/sample/face.h"

#include <Eigen/Geometry>

namespace kappamu::calib {

Eigen::Vector3d face_point(const GridShape& grid, Face face, double u, double v) {
  const int axis = axis_of(face);
  const auto [u_axis, v_axis] = face_axes(face);
  Eigen::Vector3d point;
  point[axis] = is_plus(face) ? grid.voxel_mm * grid.extent(axis) : 0.0;
  point[u_axis] = grid.voxel_mm * u;
  point[v_axis] = grid.voxel_mm * v;
  return point;
}

std::array<Eigen::Vector3d, 4> face_corners(const GridShape& grid, Face face) {
  const FaceShape shape = face_shape(grid, face);
  return {face_point(grid, face, 0, 0), face_point(grid, face, shape.nu, 0),
          face_point(grid, face, shape.nu, shape.nv), face_point(grid, face, 0, shape.nv)};
}

Eigen::Vector3d face_normal(Face face) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[axis_of(face)] = is_plus(face) ? 1.0 : -1.0;
  return normal;
}

bool seen_mirrored(Face face) {
  // The camera looks against the outward normal, with v down its right is v x (-normal). That is u
  // exactly when u x v points inward.
  const auto [u_axis, v_axis] = face_axes(face);
  const Eigen::Vector3d across = Eigen::Vector3d::Unit(u_axis).cross(Eigen::Vector3d::Unit(v_axis));
  return across.dot(face_normal(face)) > 0.0;
}

std::array<Eigen::Vector2d, 4> from_clockwise(Face face,
                                              const std::array<Eigen::Vector2d, 4>& clockwise) {
  const auto& [top_left, top_right, bottom_right, bottom_left] = clockwise;
  if (seen_mirrored(face)) return {top_right, top_left, bottom_left, bottom_right};
  return clockwise;
}

}  // namespace kappamu::calib
