#include "calib/sample/pose.h"

#include <Eigen/Core>
#include <algorithm>
#include <numbers>

#include "calib/lens/lens_model.h"
#include "calib/lens/pose_numbers.h"
#include "calib/sample/face.h"
#include "calib/sample/outline.h"
#include "calib/sample/pose_fit.h"
#include "core/error.h"
#include "core/numbers/linear_algebra.h"
#include "core/shown_text.h"

namespace kappamu::calib {
namespace {

/// The better of the refined solutions of the planar problem.
template <class Refine>
Refined best_pose(const Corners& corners_px, const Lens& lens, const Corners3& corners,
                  const Refine& refine) {
  Refined best;
  for (const Six& start : planar_poses(corners_px, lens, corners)) {
    const Refined refined = refine(start);
    if (refined.cost < best.cost) best = refined;
  }
  return best;
}

/// The sides of a quadrilateral, each turned so that the bright side lies to its right.
std::vector<std::vector<Eigen::Vector2d>> straight_edges(const Corners& corners, bool mirrored) {
  std::vector<std::vector<Eigen::Vector2d>> edges;
  for (std::size_t k = 0; k < 4; ++k) {
    edges.push_back({corners[k], corners[(k + 1) % 4]});
    if (mirrored) std::swap(edges.back()[0], edges.back()[1]);
  }
  return edges;
}

/// The projected edges as polylines, each turned so that the bright side lies to its right.
std::vector<std::vector<Eigen::Vector2d>> projected_edges(const Lens& lens, const Rigid& pose,
                                                          const Corners3& corners, bool mirrored) {
  constexpr int pieces = 16;
  std::vector<std::vector<Eigen::Vector2d>> edges;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d& start = corners[k];
    const Eigen::Vector3d& end = corners[(k + 1) % 4];
    std::vector<Eigen::Vector2d> line;
    for (int i = 0; i <= pieces; ++i) {
      const double t = static_cast<double>(i) / pieces;
      line.push_back(lens.project(pose * (start + (mirrored ? 1.0 - t : t) * (end - start))));
    }
    edges.push_back(std::move(line));
  }
  return edges;
}

/// What the lens' uncertainty does to a pose: each independent direction of its covariance, a part
/// of a standard deviation to either side, with the pose refined from where it is: found anew, its
/// rotation vector may come out as the one of the same rotation, a whole turn away (a camera behind
/// the sample is turned by about 180°), and whole deviations of a badly known lens may take it to
/// the planar problem's other solution.
template <class Refine>
PoseCovariance lens_share(const Lens& lens, const LensCovariance& covariance,
                          const Refine& refine) {
  constexpr double part = 0.05;
  PoseCovariance share = PoseCovariance::Zero();
  const LensCovariance root = [&covariance] {
    // Scaled, so that focal lengths in pixels do not drown the distortion.
    const Eigen::Matrix<double, lens_numbers, 1> scale =
        covariance.diagonal().cwiseSqrt().cwiseMax(1e-300);
    const SymmetricEigen eigen = symmetric_eigen(scale.cwiseInverse().asDiagonal() * covariance *
                                                 scale.cwiseInverse().asDiagonal());
    return LensCovariance(scale.asDiagonal() * eigen.vectors *
                          eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal());
  }();
  for (int k = 0; k < lens_numbers; ++k) {
    if (root.col(k).norm() == 0.0) continue;
    std::array<Eigen::Matrix<double, 6, 1>, 2> poses;
    for (int side = 0; side < 2; ++side) {
      LensNumbers numbers = numbers_of(lens);
      for (int n = 0; n < lens_numbers; ++n) numbers[n] += (side == 0 ? part : -part) * root(n, k);
      const Six six =
          refine(lens_of(numbers, PixelShape::rectangular, lens.width, lens.height)).pose;
      poses[side] = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(six.data());
    }
    const Eigen::Matrix<double, 6, 1> change = (poses[0] - poses[1]) / (2.0 * part);
    share += change * change.transpose();
  }
  return share;
}

SamplePose result_of(const Refined& refined, const Lens& lens, const GridShape& grid, Face face) {
  SamplePose result;
  result.face = face;
  result.camera_from_sample = rigid_of(refined.pose);
  result.covariance = refined.covariance;
  result.rms_px = refined.rms_px;
  const auto corners = face_corners(grid, face);
  for (std::size_t k = 0; k < 4; ++k) {
    result.corners_px[k] = lens.project(result.camera_from_sample * corners[k]);
  }
  return result;
}

InputError does_not_fit(const std::string& name, const GridShape& grid, Face face) {
  const FaceShape shape = face_shape(grid, face);
  return InputError(
      name + ": the outline does not fit a face of " +
      shown_number(shape.nu * grid.voxel_mm, "%.2f") + " x " +
      shown_number(shape.nv * grid.voxel_mm, "%.2f") +
      " mm; check sample.grid and sample.voxel_mm in session.json, or give corners_px "
      "of this sample view in the documented order");
}

}  // namespace

PoseUncertainty pose_uncertainty(const SamplePose& pose, const Eigen::Vector3d& point_in_sample) {
  // A small turn a about the camera's axes moves the point by a x (R p); the rotation vector's own
  // change is that turn through its left Jacobian.
  const std::array<double, 6> six = six_of(pose.camera_from_sample);
  Eigen::Matrix<double, 3, 6> move;
  constexpr double step = 1e-6;
  for (int k = 0; k < 6; ++k) {
    std::array<double, 6> up = six;
    std::array<double, 6> down = six;
    up[k] += step;
    down[k] -= step;
    move.col(k) =
        (rigid_of(up) * point_in_sample - rigid_of(down) * point_in_sample) / (2.0 * step);
  }
  Eigen::Matrix3d turn;
  for (int k = 0; k < 3; ++k) {
    std::array<double, 6> up = six;
    up[k] += step;
    const Eigen::AngleAxisd angle(rigid_of(up).rotation *
                                  pose.camera_from_sample.rotation.transpose());
    turn.col(k) = angle.angle() * angle.axis() / step;
  }
  const PoseCovariance covariance = pose.total_covariance();
  const Eigen::Matrix3d turn_covariance =
      turn * covariance.topLeftCorner<3, 3>() * turn.transpose();
  return {(move * covariance * move.transpose()).diagonal().cwiseSqrt(),
          std::sqrt(std::max(0.0, symmetric_eigen(turn_covariance).values[2])) * 180.0 /
              std::numbers::pi};
}

SamplePose find_sample_pose(const Image<float>& grey, const Lens& lens, const GridShape& grid,
                            Face face, const std::string& name,
                            const LensCovariance& lens_covariance) {
  const Quad quad = find_bright_quad(grey, name);
  const auto corners = face_corners(grid, face);
  // The coarse outline may be some pixels off: search wide around it first. Those points decide
  // between the planar problem's two solutions; then search narrow around the fitted outline.
  constexpr double wide_px = 8.0;
  constexpr double narrow_px = 5.0;
  const bool mirrored = seen_mirrored(face);
  std::vector<std::vector<Eigen::Vector2d>> edges =
      edge_points(grey, straight_edges(from_clockwise(face, quad), mirrored), wide_px);
  Refined best = best_pose(from_clockwise(face, quad), lens, corners, [&](const Six& start) {
    return refine_on_edges(edges, lens, corners, start);
  });
  for (int pass = 0; pass < 2 && std::isfinite(best.cost); ++pass) {
    const auto lines = projected_edges(lens, rigid_of(best.pose), corners, mirrored);
    edges = edge_points(grey, lines, narrow_px);
    for (std::size_t k = 0; k < 4; ++k) {
      constexpr double smallest_part_found = 0.4;  // of an edge, at one point per pixel
      const double length = (lines[k].back() - lines[k].front()).norm();
      if (static_cast<double>(edges[k].size()) < smallest_part_found * length) {
        throw does_not_fit(name, grid, face);
      }
    }
    best = refine_on_edges(edges, lens, corners, within_half_turn(best.pose));
  }
  constexpr double largest_rms_px = 2.0;  // beyond this it is another shape
  if (!std::isfinite(best.cost) || best.rms_px > largest_rms_px) {
    throw does_not_fit(name, grid, face);
  }
  SamplePose result = result_of(best, lens, grid, face);
  result.lens_covariance = lens_share(lens, lens_covariance, [&](const Lens& other) {
    return refine_on_edges(edges, other, corners, best.pose);
  });
  for (const auto& edge : edges) {
    result.edge_px.insert(result.edge_px.end(), edge.begin(), edge.end());
  }
  return result;
}

SamplePose pose_from_corners(const std::array<Eigen::Vector2d, 4>& corners_px, const Lens& lens,
                             const GridShape& grid, Face face, const std::string& name,
                             const LensCovariance& lens_covariance) {
  const auto corners = face_corners(grid, face);
  const Refined best = best_pose(corners_px, lens, corners, [&](const Six& start) {
    return refine_on_corners(corners_px, lens, corners, start);
  });
  const Refined refined = refine_on_corners(corners_px, lens, corners, within_half_turn(best.pose));
  SamplePose result = result_of(refined, lens, grid, face);
  result.lens_covariance = lens_share(lens, lens_covariance, [&](const Lens& other) {
    return refine_on_corners(corners_px, other, corners, refined.pose);
  });
  const Eigen::Vector3d eye = result.camera_from_sample.inverse().translation;
  const Eigen::Vector3d on_face = face_point(grid, face, 0.0, 0.0);
  constexpr double largest_rms_px = 10.0;  // clicked by hand
  if (!std::isfinite(refined.cost) || refined.rms_px > largest_rms_px ||
      (eye - on_face).dot(face_normal(face)) <= 0.0) {
    throw does_not_fit(name, grid, face);
  }
  return result;
}

}  // namespace kappamu::calib
