#include "data_synthetic/rig/render.h"

#include <algorithm>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::synthetic {

using Eigen::Vector2d;
using Eigen::Vector3d;

RayTable::RayTable(const calib::Lens& lens, int per_side)
    : width_(lens.width),
      height_(lens.height),
      per_side_(per_side),
      focal_px_(0.5 * (lens.fx + lens.fy)),
      directions_(static_cast<std::size_t>(lens.width) * lens.height * per_pixel()) {
  for_rows(height_, [&](int y) {
    for (int x = 0; x < width_; ++x) {
      for (int n = 0; n < per_pixel(); ++n) {
        const int row = n / per_side_;
        const int column = n % per_side_;
        const Vector2d offset((column + 0.5) / per_side_ - 0.5, (row + 0.5) / per_side_ - 0.5);
        const Vector3d d = lens.unproject(Vector2d(x, y) + offset);
        directions_[(static_cast<std::size_t>(y) * width_ + x) * per_pixel() + n] = {
            static_cast<float>(d.x()), static_cast<float>(d.y())};
      }
    }
  });
}

double coverage(double position, double low, double high, double width) {
  const double from = std::max(position - 0.5 * width, low);
  const double to = std::min(position + 0.5 * width, high);
  return std::clamp((to - from) / width, 0.0, 1.0);
}

namespace {

/// Where a ray meets a quad's plane, in the quad's frame.
struct Hit {
  Vector2d at = Vector2d::Zero();
  Vector2d footprint = Vector2d::Zero();  // extent along x and y of the ray's share of the picture
};

/// `spacing` is the distance between neighbouring rays at unit depth.
std::optional<Hit> meet_plane(const Rigid& quad_from_camera, const Vector3d& direction,
                              double spacing) {
  const Vector3d ray = quad_from_camera.rotation * direction;
  const Vector3d& origin = quad_from_camera.translation;
  const double distance = -origin.z() / ray.z();
  if (ray.z() <= 0.0 || distance <= 0.0) return std::nullopt;
  Hit hit;
  hit.at = (origin + distance * ray).head<2>();
  for (int axis = 0; axis < 2; ++axis) {
    const Vector3d turn = quad_from_camera.rotation.col(axis);
    const Vector3d shift = distance * (turn - turn.z() / ray.z() * ray);
    hit.footprint += spacing * shift.head<2>().cwiseAbs();
  }
  return hit;
}

/// Irradiance of the light at a point of the quad.
double irradiance(const Illumination& light, const Quad& quad, const Vector2d& at) {
  double sum = light.ambient;
  if (light.projector != nullptr && light.thrown != nullptr) {
    const Vector3d normal = -quad.world_from_quad.rotation.col(2);
    const ProjectorSample sample = sample_projector(
        *light.projector, quad.world_from_quad * Vector3d(at.x(), at.y(), 0.0), normal);
    if (sample.white > 0.0) sum += sample.white * thrown_value(*light.thrown, sample.pixel);
  }
  return sum;
}

}  // namespace

Image<float> render_quads(const RayTable& rays, const Rigid& world_from_camera,
                          const std::vector<Quad>& quads, const Illumination& light) {
  std::vector<Rigid> quad_from_camera;
  quad_from_camera.reserve(quads.size());
  for (const Quad& quad : quads) {
    quad_from_camera.push_back(quad.world_from_quad.inverse() * world_from_camera);
  }
  const double spacing = 1.0 / (rays.focal_px() * rays.per_side());
  Image<float> image(rays.width(), rays.height(), 3);
  for_rows(rays.height(), [&](int y) {
    for (int x = 0; x < rays.width(); ++x) {
      std::array<double, 3> sum{};
      for (int n = 0; n < rays.per_pixel(); ++n) {
        const Vector3d direction = rays.direction(x, y, n);
        double open = 1.0;  // part of the ray that no quad so far has stopped
        for (std::size_t q = 0; q < quads.size() && open > 0.0; ++q) {
          const Quad& quad = quads[q];
          const std::optional<Hit> hit = meet_plane(quad_from_camera[q], direction, spacing);
          if (!hit) continue;
          const double present =
              open * coverage(hit->at.x(), quad.low.x(), quad.high.x(), hit->footprint.x()) *
              coverage(hit->at.y(), quad.low.y(), quad.high.y(), hit->footprint.y());
          if (present <= 0.0) continue;
          open -= present;
          const std::array<double, 3> albedo = quad.albedo(hit->at, hit->footprint);
          const double light_here = present * irradiance(light, quad, hit->at);
          for (int c = 0; c < 3; ++c) sum[c] += albedo[c] * light_here;
        }
      }
      for (int c = 0; c < 3; ++c) {
        image(x, y, c) = static_cast<float>(sum[c] / (std::numbers::pi * rays.per_pixel()));
      }
    }
  });
  return image;
}

FaceView::FaceView(const RayTable& rays, const Rigid& world_from_camera,
                   const Rigid& world_from_sample, const GridShape& surface, Face face,
                   const BoundaryConstants& constants)
    : width_(rays.width()),
      height_(rays.height()),
      per_pixel_(rays.per_pixel()),
      shape_(face_shape(surface, face)),
      factor_(static_cast<std::size_t>(width_) * height_),
      position_(factor_.size() * per_pixel_, {-1.0F, -1.0F}) {
  check(axis_of(face) == 2, "the simulated camera looks at a z face");
  const Rigid sample_from_camera = world_from_sample.inverse() * world_from_camera;
  const Vector3d origin = sample_from_camera.translation;
  const double plane_z = is_plus(face) ? surface.nz * surface.voxel_mm : 0.0;
  const double outward = is_plus(face) ? 1.0 : -1.0;
  for_rows(height_, [&](int y) {
    for (int x = 0; x < width_; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * width_ + x;
      double cosines = 0.0;
      for (int n = 0; n < per_pixel_; ++n) {
        const Vector3d ray = sample_from_camera.rotation * rays.direction(x, y, n);
        const double cos_outside = -outward * ray.z() / ray.norm();
        if (cos_outside <= 0.0) continue;
        cosines += cos_outside / per_pixel_;
        const Vector3d at = origin + (plane_z - origin.z()) / ray.z() * ray;
        const double u = at.x() / surface.voxel_mm;
        const double v = at.y() / surface.voxel_mm;
        if (u < 0.0 || v < 0.0 || u > shape_.nu || v > shape_.nv) continue;
        position_[pixel * per_pixel_ + n] = {static_cast<float>(u), static_cast<float>(v)};
      }
      if (cosines > 0.0) {
        factor_[pixel] =
            static_cast<float>(radiance_per_exitance(constants, std::min(cosines, 1.0)));
      }
    }
  });
}

bool FaceView::covers(int x, int y) const {
  const std::size_t first = (static_cast<std::size_t>(y) * width_ + x) * per_pixel_;
  return std::all_of(position_.begin() + static_cast<std::ptrdiff_t>(first),
                     position_.begin() + static_cast<std::ptrdiff_t>(first + per_pixel_),
                     [](const std::array<float, 2>& at) { return at[0] >= 0.0F; });
}

Image<float> FaceView::radiance(const std::vector<std::vector<double>>& exitance) const {
  const int channels = static_cast<int>(exitance.size());
  Image<float> image(width_, height_, channels);
  for_rows(height_, [&](int y) {
    std::vector<double> sum(channels);
    for (int x = 0; x < width_; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * width_ + x;
      std::fill(sum.begin(), sum.end(), 0.0);
      for (int n = 0; n < per_pixel_; ++n) {
        const std::array<float, 2>& at = position_[pixel * per_pixel_ + n];
        if (at[0] < 0.0F) continue;
        // On the outer half cell the line through the last two centres goes on: the exitance falls
        // steeply towards an open edge.
        const int u0 = std::clamp(static_cast<int>(at[0] - 0.5), 0, std::max(shape_.nu - 2, 0));
        const int v0 = std::clamp(static_cast<int>(at[1] - 0.5), 0, std::max(shape_.nv - 2, 0));
        const double fu = shape_.nu > 1 ? at[0] - 0.5 - u0 : 0.0;
        const double fv = shape_.nv > 1 ? at[1] - 0.5 - v0 : 0.0;
        const std::size_t here = static_cast<std::size_t>(v0) * shape_.nu + u0;
        const std::size_t right = u0 + 1 < shape_.nu ? here + 1 : here;
        const std::size_t down = v0 + 1 < shape_.nv ? static_cast<std::size_t>(shape_.nu) : 0;
        for (int c = 0; c < channels; ++c) {
          const std::vector<double>& map = exitance[c];
          sum[c] += (1.0 - fv) * ((1.0 - fu) * map[here] + fu * map[right]) +
                    fv * ((1.0 - fu) * map[here + down] + fu * map[right + down]);
        }
      }
      for (int c = 0; c < channels; ++c) {
        image(x, y, c) = static_cast<float>(std::max(0.0, sum[c]) * factor_[pixel] / per_pixel_);
      }
    }
  });
  return image;
}

}  // namespace kappamu::synthetic
