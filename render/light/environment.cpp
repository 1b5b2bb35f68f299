#include "render/light/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "core/error.h"
#include "render/linear_image.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// A constant radiance is an image of one pixel.
Image<float> image_of(const EnvironmentLight& light) {
  Image<float> image = light.image ? read_linear_image(*light.image) : Image<float>(1, 1, 3, 1.0F);
  // Cube maps and light probes have other shapes.
  if (light.image && std::abs(image.width() - 2 * image.height()) > 1) {
    throw InputError(light.image->string() + ": is " + std::to_string(image.width()) + " x " +
                     std::to_string(image.height()) +
                     " pixels; a latitude-longitude environment is twice as wide as high: convert "
                     "it");
  }
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.values()[i] *= static_cast<float>(light.radiance[static_cast<Eigen::Index>(i % 3)]);
  }
  return image;
}

}  // namespace

Environment::Environment(const EnvironmentLight& light, LampsEnter lamps)
    : image_(image_of(light)),
      turn_(light.turn_deg * pi / 180.0),
      lamps_(lamps),
      visible_(light.visible) {
  std::vector<double> bright;
  double mean = 0.0;
  for (int y = 0; y < image_.height(); ++y) {
    for (int x = 0; x < image_.width(); ++x) {
      mean += luminance(pixel(image_, x, y)) * solid_angle(bright.size()) / (4.0 * pi);
      bright.push_back(luminance(pixel(image_, x, y)));
    }
  }
  dark_ = mean <= 0.0;
  even_ = (1.0 + 1e-9) * std::min(mean, median_of(bright));
  double sum = 0.0;
  for (std::size_t i = 0; i < bright.size(); ++i) {
    sum += std::max(0.0, bright[i] - even_) * solid_angle(i);
    cumulative_.push_back(sum);
  }
}

/// Over solid angle.
double Environment::median_of(const std::vector<double>& bright) const {
  std::vector<std::size_t> order(bright.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return bright[a] < bright[b]; });
  double below = 0.0;
  for (const std::size_t i : order) {
    below += solid_angle(i);
    if (below >= 2.0 * pi) return bright[i];
  }
  return bright[order.back()];
}

double Environment::solid_angle(std::size_t pixel) const {
  const auto row = static_cast<double>(pixel / static_cast<std::size_t>(image_.width()));
  const double top = std::cos(pi * row / image_.height());
  const double bottom = std::cos(pi * (row + 1.0) / image_.height());
  return 2.0 * pi / image_.width() * (top - bottom);
}

std::size_t Environment::pixel_of(const Vector3d& direction) const {
  if (even()) return 0;
  const double turned = std::atan2(direction.x(), -direction.z()) + turn_;
  const double u = turned / (2.0 * pi) + 0.5;
  const double v = std::acos(std::clamp(direction.y(), -1.0, 1.0)) / pi;
  const int x =
      std::min(static_cast<int>((u - std::floor(u)) * image_.width()), image_.width() - 1);
  const int y = std::min(static_cast<int>(v * image_.height()), image_.height() - 1);
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width()) +
         static_cast<std::size_t>(x);
}

Colour Environment::radiance(const Vector3d& direction) const {
  const float* rgb = &image_.values()[3 * pixel_of(direction)];
  return {rgb[0], rgb[1], rgb[2]};
}

Colour Environment::of_lamps(const Vector3d& direction) const {
  const Colour here = radiance(direction);
  const double bright = luminance(here);
  return bright > even_ ? Colour((1.0 - even_ / bright) * here) : Colour::Zero();
}

double Environment::density(const Vector3d& direction) const {
  if (even()) return 0.0;
  const std::size_t i = pixel_of(direction);
  const double power = cumulative_[i] - (i > 0 ? cumulative_[i - 1] : 0.0);
  return power / cumulative_.back() / solid_angle(i);
}

Environment::Sample Environment::sample(double u, double v) const {
  const double target = u * cumulative_.back();
  const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end() - 1, target);
  const auto i = static_cast<std::size_t>(found - cumulative_.begin());
  const double below = i > 0 ? cumulative_[i - 1] : 0.0;
  const double power = cumulative_[i] - below;
  // What `u` leaves within its pixel goes along the row.
  const double along = power > 0.0 ? std::clamp((target - below) / power, 0.0, 1.0) : 0.5;
  const auto width = static_cast<std::size_t>(image_.width());
  const auto x = static_cast<double>(i % width), y = static_cast<double>(i / width);
  const double angle = 2.0 * pi * ((x + along) / image_.width() - 0.5) - turn_;
  const double top = std::cos(pi * y / image_.height());
  const double bottom = std::cos(pi * (y + 1.0) / image_.height());
  const double up = top + v * (bottom - top);
  const double across = std::sqrt(std::max(0.0, 1.0 - up * up));
  Sample sample;
  sample.direction = {across * std::sin(angle), up, -across * std::cos(angle)};
  const float* rgb = &image_.values()[3 * i];
  sample.radiance = {rgb[0], rgb[1], rgb[2]};
  sample.density = power / cumulative_.back() / solid_angle(i);
  return sample;
}

std::optional<Environment> make_environment(const std::vector<Light>& lights, LampsEnter lamps) {
  for (const Light& light : lights) {
    if (const auto* found = std::get_if<EnvironmentLight>(&light)) {
      Environment environment(*found, lamps);
      if (!environment.dark()) return environment;
    }
  }
  return std::nullopt;
}

}  // namespace kappamu::render
