#include "calib/light/irradiance.h"

#include <algorithm>
#include <cmath>

#include "calib/sample/face.h"
#include "core/error.h"

namespace kappamu::calib {

LitFace::LitFace(const Lens& projector, const Rigid& projector_from_sample, const GridShape& grid,
                 Face face, const FlatField& flat, double projector_black)
    : width_(projector.width),
      height_(projector.height),
      black_(static_cast<float>(projector_black)) {
  const FaceShape shape = face_shape(grid, face);
  voxels_ = shape.cells();
  const auto pixel = [&](double u, double v) {
    return projector.project(projector_from_sample * face_point(grid, face, u, v));
  };
  const double u_middle = 0.5 * shape.nu;
  const double v_middle = 0.5 * shape.nv;
  const double pixels_per_voxel =
      std::max((pixel(u_middle + 1.0, v_middle) - pixel(u_middle, v_middle)).norm(),
               (pixel(u_middle, v_middle + 1.0) - pixel(u_middle, v_middle)).norm());
  constexpr int fewest_points = 4;
  const int points = std::max(fewest_points, static_cast<int>(std::ceil(pixels_per_voxel)));
  per_voxel_ = points * points;
  points_.reserve(voxels_ * static_cast<std::size_t>(per_voxel_));
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      for (int n = 0; n < per_voxel_; ++n) {
        const double pu = u + (n % points + 0.5) / points;
        const int row = n / points;
        const double pv = v + (row + 0.5) / points;
        const Eigen::Vector2d at = pixel(pu, pv);
        const bool reached = projector.contains(at);
        const double white =
            reached ? flat(2.0 * pu / shape.nu - 1.0, 2.0 * pv / shape.nv - 1.0) : 0.0;
        points_.push_back(
            {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(white)});
      }
    }
  }
}

std::vector<float> LitFace::irradiance(const Image<std::uint16_t>& pattern,
                                       const LightTable& light) const {
  check(pattern.width() == width_ && pattern.height() == height_ && pattern.channels() == 1,
        "a pattern has the projector's size and one channel");
  const auto at = [&](int column, int row) {
    return light[std::min<std::size_t>(pattern(column, row), light.size() - 1)];
  };
  std::vector<float> result(voxels_);
  std::size_t k = 0;
  for (float& mean : result) {
    double sum = 0.0;
    for (int n = 0; n < per_voxel_; ++n, ++k) {
      const Point& point = points_[k];
      if (point.white <= 0.0F) continue;
      const float x = std::clamp(point.x, 0.0F, static_cast<float>(width_ - 1));
      const float y = std::clamp(point.y, 0.0F, static_cast<float>(height_ - 1));
      const int x0 = std::min(static_cast<int>(x), std::max(width_ - 2, 0));
      const int y0 = std::min(static_cast<int>(y), std::max(height_ - 2, 0));
      const int x1 = std::min(x0 + 1, width_ - 1);
      const int y1 = std::min(y0 + 1, height_ - 1);
      const float fx = x - static_cast<float>(x0);
      const float fy = y - static_cast<float>(y0);
      const float share = (1.0F - fy) * ((1.0F - fx) * at(x0, y0) + fx * at(x1, y0)) +
                          fy * ((1.0F - fx) * at(x0, y1) + fx * at(x1, y1));
      sum += point.white * (black_ + (1.0F - black_) * share);
    }
    mean = static_cast<float>(sum / per_voxel_);
  }
  return result;
}

double LitFace::reached() const {
  const auto count = std::count_if(points_.begin(), points_.end(),
                                   [](const Point& point) { return point.white > 0.0F; });
  return static_cast<double>(count) / static_cast<double>(points_.size());
}

}  // namespace kappamu::calib
