#include "calib/sample/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "calib/sample/face.h"
#include "core/parallel.h"

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

  /// Part of a pixel that shows the face, by 8 x 8 rays; 1 where its middle shows a point that lies
  /// `rim` voxels and more inside.
  double coverage(int x, int y, double rim) const {
    if (is_inside({x, y}, rim)) return 1.0;
    constexpr int rays = 8;
    int hits = 0;
    for (int n = 0; n < rays * rays; ++n) {
      const int row = n / rays;
      const Eigen::Vector2d at(x + (n % rays + 0.5) / rays - 0.5, y + (row + 0.5) / rays - 0.5);
      const auto [u, v] = seen_at(at);
      if (u >= 0.0 && v >= 0.0 && u <= shape_.nu && v <= shape_.nv) ++hits;
    }
    return static_cast<double>(hits) / (rays * rays);
  }

  /// Whether the point of the picture shows one of the face, `rim` voxels and more inside.
  bool is_inside(const Eigen::Vector2d& pixel, double rim) const {
    const auto [u, v] = seen_at(pixel);
    return u >= rim && v >= rim && u <= shape_.nu - rim && v <= shape_.nv - rim;
  }

 private:
  /// The point of the face's plane, in voxels.
  std::array<double, 2> seen_at(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector3d ray = camera_.unproject(pixel);
    const Eigen::Vector3d hit = ray * (origin_.dot(normal_) / ray.dot(normal_)) - origin_;
    return {hit.dot(u_step_) / u_step_.squaredNorm(), hit.dot(v_step_) / v_step_.squaredNorm()};
  }

  Lens camera_;
  FaceShape shape_;
  Eigen::Vector3d origin_;
  Eigen::Vector3d u_step_;
  Eigen::Vector3d v_step_;
  Eigen::Vector3d normal_;
};

/// Where `points` x `points` points of one voxel are seen. Every fourth is projected, the others
/// lie between: a lens and a perspective bend less than 1e-3 px over two pixels.
void find_places(const SeenFace& seen, int u, int v, int points,
                 std::vector<Eigen::Vector2d>& places) {
  constexpr int step = 4;
  const int squares = (points + step - 1) / step;
  const auto row_of_corners = [&](int row) {
    std::vector<Eigen::Vector2d> corners;
    for (int k = 0; k <= squares; ++k) {
      corners.push_back(seen.pixel(u + static_cast<double>(k * step) / points,
                                   v + static_cast<double>(row * step) / points));
    }
    return corners;
  };
  places.clear();
  std::vector<Eigen::Vector2d> above, below = row_of_corners(0), here(below.size());
  for (int y = 0; y < points; ++y) {
    if (y % step == 0) {
      above = std::move(below);
      below = row_of_corners(y / step + 1);
    }
    const double down = (y % step + 0.5) / step;
    for (std::size_t k = 0; k < here.size(); ++k)
      here[k] = (1.0 - down) * above[k] + down * below[k];
    for (int x = 0; x < points; ++x) {
      const double across = (x % step + 0.5) / step;
      const auto k = static_cast<std::size_t>(x / step);
      places.emplace_back((1.0 - across) * here[k] + across * here[k + 1]);
    }
  }
}

/// Weights of the pixels of one voxel, in the order of their numbers.
class VoxelWeights {
 public:
  /// The points' places in the picture, all of them inside by a pixel.
  void add(const std::vector<Eigen::Vector2d>& points, float point_weight) {
    Eigen::Vector2d low = points.front(), high = points.front();
    for (const Eigen::Vector2d& at : points) {
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
    left_ = static_cast<int>(low.x());
    top_ = static_cast<int>(low.y());
    width_ = static_cast<int>(high.x()) + 2 - left_;
    weights_.assign(static_cast<std::size_t>(width_) *
                        static_cast<std::size_t>(static_cast<int>(high.y()) + 2 - top_),
                    0.0F);
    for (const Eigen::Vector2d& at : points) {
      const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
      const auto fx = static_cast<float>(at.x() - x), fy = static_cast<float>(at.y() - y);
      float* first = &weights_[static_cast<std::size_t>(y - top_) * width_ + (x - left_)];
      first[0] += point_weight * (1.0F - fx) * (1.0F - fy);
      first[1] += point_weight * fx * (1.0F - fy);
      first[width_] += point_weight * (1.0F - fx) * fy;
      first[width_ + 1] += point_weight * fx * fy;
    }
  }
  /// act(x, y, weight)
  template <class Act>
  void for_each(const Act& act) const {
    for (std::size_t k = 0; k < weights_.size(); ++k) {
      if (weights_[k] <= 0.0F) continue;
      act(left_ + static_cast<int>(k) % width_, top_ + static_cast<int>(k) / width_, weights_[k]);
    }
  }

 private:
  std::vector<float> weights_;
  int left_ = 0, top_ = 0, width_ = 0;
};

/// SeenFace::coverage() of pixels that are asked for row by row. A tile of the picture whose
/// corners show the face's inside shows nothing else: a lens bends less over its pixels than the
/// rim is wide.
class TiledCoverage {
 public:
  TiledCoverage(const SeenFace& seen, int width, double rim)
      : seen_(seen), rim_(rim), inside_(static_cast<std::size_t>(width / tile + 1)) {}

  double at(int x, int y) {
    if (y / tile != row_) std::fill(inside_.begin(), inside_.end(), std::nullopt);
    row_ = y / tile;
    std::optional<bool>& inside = inside_[static_cast<std::size_t>(x / tile)];
    if (!inside) inside = is_inside(x / tile * tile, row_ * tile);
    return *inside ? 1.0 : seen_.coverage(x, y, rim_);
  }

 private:
  static constexpr int tile = 16;  // [px]

  bool is_inside(int left, int top) const {
    for (const int y : {top, top + tile})
      for (const int x : {left, left + tile})
        if (!seen_.is_inside({x, y}, rim_)) return false;
    return true;
  }

  const SeenFace& seen_;
  double rim_;
  int row_ = -1;
  std::vector<std::optional<bool>> inside_;  ///< of the tiles of the row
};

/// Puts the voxels of `row`, one line of a face, behind those of `result`.
void append(const Footprints& row, Footprints& result) {
  const std::size_t before = result.pixel.size();
  for (std::size_t k = 1; k < row.begin.size(); ++k) result.begin.push_back(before + row.begin[k]);
  const auto add = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  add(row.pixel, result.pixel);
  add(row.weight, result.weight);
  add(row.inverse_coverage, result.inverse_coverage);
  add(row.cos_outside, result.cos_outside);
  add(row.visible, result.visible);
}

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
  const double rim = 1.5 / result.pixels_per_voxel;  // pixels here may look beyond the edge
  result.begin.push_back(0);
  std::vector<Footprints> rows(static_cast<std::size_t>(shape.nv));
  for_rows(shape.nv, [&](int v) {
    Footprints& row = rows[static_cast<std::size_t>(v)];
    row.begin.push_back(0);
    std::vector<Eigen::Vector2d> places;
    VoxelWeights weights;
    TiledCoverage coverage(seen, camera.width, 2.0 * rim);
    for (int u = 0; u < shape.nu; ++u) {
      const double cosine = seen.cos_outside(u + 0.5, v + 0.5);
      bool visible = cosine > 0.0;
      if (visible) find_places(seen, u, v, points, places);
      for (std::size_t n = 0; n < places.size() && visible; ++n) {
        const Eigen::Vector2d& at = places[n];
        visible = at.x() >= 0.0 && at.y() >= 0.0 && at.x() < camera.width - 1 &&
                  at.y() < camera.height - 1;
      }
      double covered = 1.0;
      if (visible) weights.add(places, point_weight);
      if (visible && (u < rim || v < rim || u + 1.0 > shape.nu - rim || v + 1.0 > shape.nv - rim)) {
        covered = 0.0;
        weights.for_each(
            [&](int x, int y, float weight) { covered += weight * coverage.at(x, y); });
      }
      constexpr double least_covered = 0.25;
      visible = visible && covered > least_covered;
      if (visible) {
        weights.for_each([&](int x, int y, float weight) {
          row.pixel.push_back(static_cast<std::uint32_t>(y) * camera.width + x);
          row.weight.push_back(weight);
        });
      }
      row.begin.push_back(row.pixel.size());
      row.inverse_coverage.push_back(visible ? 1.0 / covered : 0.0);
      row.cos_outside.push_back(cosine);
      row.visible.push_back(visible ? 1 : 0);
    }
  });
  std::size_t pixels = 0;
  for (const Footprints& row : rows) pixels += row.pixel.size();
  result.pixel.reserve(pixels);
  result.weight.reserve(pixels);
  for (Footprints& row : rows) append(std::exchange(row, {}), result);
  return result;
}

}  // namespace kappamu::calib
