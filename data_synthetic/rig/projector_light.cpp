#include "data_synthetic/rig/projector_light.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::synthetic {

namespace {

std::vector<double> gaussian_kernel(double sigma) {
  const int radius = static_cast<int>(std::ceil(4.0 * sigma));
  std::vector<double> kernel(2 * static_cast<std::size_t>(radius) + 1);
  double sum = 0.0;
  for (int i = -radius; i <= radius; ++i) {
    kernel[i + radius] = sigma > 0.0 ? std::exp(-0.5 * i * i / (sigma * sigma)) : 1.0;
    sum += kernel[i + radius];
  }
  for (double& weight : kernel) weight /= sum;
  return kernel;
}

enum class Along { x, y };

/// One pass; the image continues beyond its edge with its last pixels.
Image<float> blur(const Image<float>& image, const std::vector<double>& kernel, Along axis) {
  const bool along_x = axis == Along::x;
  Image<float> out(image.width(), image.height(), 1);
  const int radius = static_cast<int>(kernel.size() / 2);
  for_rows(image.height(), [&](int y) {
    for (int x = 0; x < image.width(); ++x) {
      double sum = 0.0;
      for (int i = -radius; i <= radius; ++i) {
        const int at_x = along_x ? std::clamp(x + i, 0, image.width() - 1) : x;
        const int at_y = along_x ? y : std::clamp(y + i, 0, image.height() - 1);
        sum += kernel[i + radius] * image(at_x, at_y);
      }
      out(x, y) = static_cast<float>(sum);
    }
  });
  return out;
}

}  // namespace

Image<float> thrown_image(const ProjectorModel& projector, const Image<float>& shown) {
  check(shown.width() == projector.lens.width && shown.height() == projector.lens.height &&
            shown.channels() == 1,
        "a projected image is grey and of the projector's size");
  const std::vector<double> kernel = gaussian_kernel(projector.defocus_px);
  Image<float> light = shown;
  if (projector.gamma != 1.0) {
    for (float& value : light.values()) {
      value = static_cast<float>(std::pow(static_cast<double>(value), projector.gamma));
    }
  }
  Image<float> out = blur(blur(light, kernel, Along::x), kernel, Along::y);
  for (float& value : out.values()) {
    value = static_cast<float>(projector.black_level + (1.0 - projector.black_level) * value);
  }
  return out;
}

ProjectorSample sample_projector(const ProjectorModel& projector, const Eigen::Vector3d& point,
                                 const Eigen::Vector3d& normal) {
  const Eigen::Vector3d local = projector.projector_from_world * point;
  ProjectorSample sample;
  if (local.z() <= 0.0) return sample;
  const double distance = local.norm();
  const double cos_incidence =
      -(projector.projector_from_world.rotation * normal).dot(local) / distance;
  sample.pixel = projector.lens.project(local);
  if (cos_incidence <= 0.0 || !projector.lens.contains(sample.pixel)) return sample;
  const Eigen::Vector2d centre(0.5 * (projector.lens.width - 1), 0.5 * (projector.lens.height - 1));
  const double relative = (sample.pixel - centre).squaredNorm() / centre.squaredNorm();
  sample.white = projector.intensity * (local.z() / distance) *
                 (1.0 - projector.falloff * relative) * cos_incidence / (distance * distance);
  return sample;
}

double thrown_value(const Image<float>& thrown, const Eigen::Vector2d& pixel) {
  const double x = std::clamp(pixel.x(), 0.0, thrown.width() - 1.0);
  const double y = std::clamp(pixel.y(), 0.0, thrown.height() - 1.0);
  const int x0 = std::min(static_cast<int>(x), thrown.width() - 2);
  const int y0 = std::min(static_cast<int>(y), thrown.height() - 2);
  const double fx = x - x0;
  const double fy = y - y0;
  return (1.0 - fy) * ((1.0 - fx) * thrown(x0, y0) + fx * thrown(x0 + 1, y0)) +
         fy * ((1.0 - fx) * thrown(x0, y0 + 1) + fx * thrown(x0 + 1, y0 + 1));
}

void set_white_reference(ProjectorModel& projector, const Eigen::Vector3d& point,
                         const Eigen::Vector3d& normal) {
  projector.intensity = 1.0;
  const double white = sample_projector(projector, point, normal).white;
  check(white > 0.0, "the projector lights the centre of the sample's lit face");
  projector.intensity = 1.0 / white;
}

}  // namespace kappamu::synthetic
