#include "render/light/light_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/linear_image.h"
#include "render/look_at.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

class Directional : public LightSource {
 public:
  explicit Directional(const DirectionalLight& light) : light_(light) {}
  Arrival at(const Vector3d& /*point*/) const override {
    return {light_.direction, std::numeric_limits<double>::infinity(), light_.irradiance};
  }

 private:
  DirectionalLight light_;
};

/// Inverse square law about a position, times what the light is made to send in that direction.
class Positional : public LightSource {
 public:
  explicit Positional(const PointLight& light) : light_(light) {}
  Arrival at(const Vector3d& point) const override {
    const Vector3d ray = point - light_.position_mm;
    const double distance = ray.norm();
    const Vector3d direction = ray / distance;
    const double fall_off = light_.at_mm / distance;
    return {direction, distance, fall_off * fall_off * light_.irradiance * shape(direction)};
  }
  const Vector3d* position() const override { return &light_.position_mm; }

 protected:
  virtual Colour shape(const Vector3d& /*direction*/) const { return Colour::Ones(); }

 private:
  PointLight light_;
};

class Spot : public Positional {
 public:
  explicit Spot(const SpotLight& light)
      : Positional(light.point),
        axis_((light.target_mm - light.point.position_mm).normalized()),
        half_cone_(0.5 * light.cone_deg * std::numbers::pi / 180.0),
        edge_(light.edge_deg * std::numbers::pi / 180.0),
        full_(std::cos(std::max(0.0, half_cone_ - edge_))) {}

 protected:
  Colour shape(const Vector3d& direction) const override {
    const double cosine = direction.dot(axis_);
    if (cosine > full_) return Colour::Ones();
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    if (angle >= half_cone_) return Colour::Zero();
    const double t = (half_cone_ - angle) / edge_;
    return Colour::Constant(t * t * (3.0 - 2.0 * t));
  }

 private:
  Vector3d axis_;
  double half_cone_, edge_, full_;  ///< [rad]; full light where the cosine exceeds `full_`
};

/// An image thrown through a pinhole. A pixel on the axis gives the point light's irradiance; off
/// the axis an even image on a plane stays even, as a projector's does.
class Projector : public Positional {
 public:
  explicit Projector(const ProjectorLight& light)
      : Positional(light.point),
        image_(read_linear_image(light.image)),
        look_(light.point.position_mm, light.target_mm, light.up, light.fov_deg,
              static_cast<double>(image_.width()) / image_.height()) {}

 protected:
  Colour shape(const Vector3d& direction) const override {
    double x = 0.0, y = 0.0;
    if (!look_.image_point(direction, x, y)) return Colour::Zero();
    const int column = std::min(static_cast<int>(x * image_.width()), image_.width() - 1);
    const int row = std::min(static_cast<int>(y * image_.height()), image_.height() - 1);
    // On a plane at depth z the distance is z/cos and the plane's irradiance E cos³ of the axis:
    // a pixel's cone of light covers the same area everywhere on it, so its intensity goes as
    // 1/cos³.
    const double cosine = direction.dot(look_.forward());
    return pixel(image_, column, row) / (cosine * cosine * cosine);
  }

 private:
  Image<float> image_;
  LookAt look_;
};

}  // namespace

LightSources make_light_sources(const std::vector<Light>& lights) {
  LightSources sources;
  for (const Light& light : lights) {
    if (const auto* directional = std::get_if<DirectionalLight>(&light)) {
      sources.push_back(std::make_unique<Directional>(*directional));
    } else if (const auto* point = std::get_if<PointLight>(&light)) {
      sources.push_back(std::make_unique<Positional>(*point));
    } else if (const auto* spot = std::get_if<SpotLight>(&light)) {
      sources.push_back(std::make_unique<Spot>(*spot));
    } else if (const auto* projector = std::get_if<ProjectorLight>(&light)) {
      sources.push_back(std::make_unique<Projector>(*projector));
    }
  }
  return sources;
}

}  // namespace kappamu::render
