#include "calib/sample/footprint.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/sample/face.h"

namespace kappamu::calib {
namespace {

/// A face seen by a camera: from voxel coordinates (u, v) to pixels and back.
class SeenFace {
 public:
  SeenFace(const Lens& camera, const Rigid& camera_from_sample, const GridShape& grid, Face face)
      : camera_(camera), shape_(face_shape(grid, face)) {
    origin_ = camera_from_sample * face_point(grid, face, 0.0, 0.0);
    u_step_ = camera_from_sample * face_point(grid, face, 1.0, 0.0) - origin_;
    v_step_ = camera_from_sample * face_point(grid, face, 0.0, 1.0) - origin_;
    normal_ = camera_from_sample.rotation * face_normal(face);
  }

  Eigen::Vector3d point(double u, double v) const { return origin_ + u * u_step_ + v * v_step_; }
  Eigen::Vector2d pixel(double u, double v) const { return camera_.project(point(u, v)); }

  double cos_outside(double u, double v) const { return -point(u, v).normalized().dot(normal_); }

  /// Part of a pixel that shows the face, by 8 x 8 rays.
  double coverage(int x, int y) const {
    constexpr int rays = 8;
    int hits = 0;
    for (int n = 0; n < rays * rays; ++n) {
      const int row = n / rays;
      const Eigen::Vector2d at(x + (n % rays + 0.5) / rays - 0.5, y + (row + 0.5) / rays - 0.5);
      const Eigen::Vector3d ray = camera_.unproject(at);
      const Eigen::Vector3d hit = ray * (origin_.dot(normal_) / ray.dot(normal_)) - origin_;
      const double u = hit.dot(u_step_) / u_step_.squaredNorm();
      const double v = hit.dot(v_step_) / v_step_.squaredNorm();
      if (u >= 0.0 && v >= 0.0 && u <= shape_.nu && v <= shape_.nv) ++hits;
    }
    return static_cast<double>(hits) / (rays * rays);
  }

 private:
  Lens camera_;
  FaceShape shape_;
  Eigen::Vector3d origin_;
  Eigen::Vector3d u_step_;
  Eigen::Vector3d v_step_;
  Eigen::Vector3d normal_;
};

}  // namespace

Footprints make_footprints(const Lens& camera, const Rigid& camera_from_sample,
                           const GridShape& grid, Face face) {
  const SeenFace seen(camera, camera_from_sample, grid, face);
  Footprints result;
  result.shape = face_shape(grid, face);
  const FaceShape& shape = result.shape;
  const double u_middle = 0.5 * shape.nu;
  const double v_middle = 0.5 * shape.nv;
  const Eigen::Vector2d middle = seen.pixel(u_middle, v_middle);
  result.pixels_per_voxel = std::max((seen.pixel(u_middle + 1.0, v_middle) - middle).norm(),
                                     (seen.pixel(u_middle, v_middle + 1.0) - middle).norm());
  constexpr double points_per_pixel = 2.0;
  constexpr int fewest_points = 4;
  const int points = std::max(
      fewest_points, static_cast<int>(std::ceil(1.2 * points_per_pixel * result.pixels_per_voxel)));
  const float point_weight = 1.0F / static_cast<float>(points * points);

  std::map<std::uint32_t, double> coverages;  // of pixels near the outline, found once
  std::map<std::uint32_t, float> weights;     // of one voxel, in order
  result.begin.push_back(0);
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      weights.clear();
      const double cosine = seen.cos_outside(u + 0.5, v + 0.5);
      bool visible = cosine > 0.0;
      for (int n = 0; n < points * points && visible; ++n) {
        const int row = n / points;
        const Eigen::Vector2d at =
            seen.pixel(u + (n % points + 0.5) / points, v + (row + 0.5) / points);
        const int x = static_cast<int>(std::floor(at.x()));
        const int y = static_cast<int>(std::floor(at.y()));
        if (x < 0 || y < 0 || x + 1 >= camera.width || y + 1 >= camera.height) {
          visible = false;
          break;
        }
        const auto fx = static_cast<float>(at.x() - x);
        const auto fy = static_cast<float>(at.y() - y);
        const auto first = static_cast<std::uint32_t>(y) * camera.width + x;
        weights[first] += point_weight * (1.0F - fx) * (1.0F - fy);
        weights[first + 1] += point_weight * fx * (1.0F - fy);
        weights[first + camera.width] += point_weight * (1.0F - fx) * fy;
        weights[first + camera.width + 1] += point_weight * fx * fy;
      }
      double covered = 1.0;
      const double rim = 1.5 / result.pixels_per_voxel;  // pixels here may look beyond the edge
      if (visible && (u < rim || v < rim || u + 1.0 > shape.nu - rim || v + 1.0 > shape.nv - rim)) {
        covered = 0.0;
        for (const auto& [pixel, weight] : weights) {
          const auto known = coverages.find(pixel);
          const double coverage =
              known != coverages.end()
                  ? known->second
                  : (coverages[pixel] = seen.coverage(static_cast<int>(pixel) % camera.width,
                                                      static_cast<int>(pixel) / camera.width));
          covered += weight * coverage;
        }
      }
      constexpr double least_covered = 0.25;
      visible = visible && covered > least_covered;
      if (visible) {
        for (const auto& [pixel, weight] : weights) {
          result.pixel.push_back(pixel);
          result.weight.push_back(weight);
        }
      }
      result.begin.push_back(result.pixel.size());
      result.inverse_coverage.push_back(visible ? 1.0 / covered : 0.0);
      result.cos_outside.push_back(cosine);
      result.visible.push_back(visible ? 1 : 0);
    }
  }
  return result;
}

}  // namespace kappamu::calib
