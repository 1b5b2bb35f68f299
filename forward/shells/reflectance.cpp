#include "forward/shells/reflectance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu::forward::shells {

using Eigen::Array3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

constexpr double exponent = 20.0;               // n of Kajiya and Kay
constexpr double tilt = -5.0 * pi / 180.0;      // α of the cuticle's scales
constexpr double roughness = 8.0 * pi / 180.0;  // β of R; TT has half, TRT twice
constexpr double index = 1.55;                  // of a hair's keratin

double gaussian(double x, double width) {
  return std::exp(-0.5 * x * x / (width * width)) / (width * std::sqrt(2.0 * pi));
}

/// Schlick's Fresnel reflectance of a hair.
double fresnel(double cosine) {
  const double f0 = std::pow((index - 1.0) / (index + 1.0), 2.0);
  return f0 + (1.0 - f0) * std::pow(1.0 - std::clamp(cosine, 0.0, 1.0), 5.0);
}

double sine_of(double cosine) {
  return std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
}

}  // namespace

HairReflectance::HairReflectance(HairModel model, double shine) : model_(model), shine_(shine) {
  if (shine < 0.0 || shine > 1.0) throw InputError("fur: shine must be 0 to 1");
  norm_.fill(1.0);
  if (model == HairModel::even) return;
  constexpr int steps = 256, turns = 48;
  for (int i = 0; i <= samples; ++i) {
    double sum = 0.0;
    for (int a = 0; a < steps; ++a) {
      const double light = -1.0 + 2.0 * (a + 0.5) / steps;
      for (int b = 0; b < turns; ++b) {
        sum += lobes(light, static_cast<double>(i) / samples, 2.0 * pi * (b + 0.5) / turns,
                     Array3d::Ones())[0];
      }
    }
    norm_[static_cast<std::size_t>(i)] = sum * 4.0 * pi / (steps * turns);
  }
}

double HairReflectance::norm(double eye) const {
  const double place = std::min(std::abs(eye), 1.0) * samples;
  const auto low = std::min(static_cast<std::size_t>(place), std::size_t{samples - 1});
  const double share = place - static_cast<double>(low);
  return (1.0 - share) * norm_[low] + share * norm_[low + 1];
}

/// Cosines of light and eye with the tangent, angle between them about it; not normalised. The tilt
/// follows the sign of the eye's cosine, so that the norm is even: a mean tangent has no root end.
Array3d HairReflectance::lobes(double light, double eye, double azimuth,
                               const Array3d& colour) const {
  if (model_ == HairModel::kajiya_kay) {
    const double along = sine_of(light) * sine_of(eye) - light * eye;
    return Array3d::Constant(std::pow(std::max(0.0, along), exponent));
  }
  const double half_angle =
      0.5 * (std::asin(std::clamp(light, -1.0, 1.0)) + std::asin(std::clamp(eye, -1.0, 1.0)));
  const double difference =
      0.5 * (std::asin(std::clamp(eye, -1.0, 1.0)) - std::asin(std::clamp(light, -1.0, 1.0)));
  const double shift = eye < 0.0 ? -tilt : tilt;
  const double cosine = std::max(0.05, std::cos(difference));
  const double half_azimuth = std::cos(0.5 * azimuth), turn = std::cos(azimuth);
  const double f = fresnel(cosine * std::abs(half_azimuth));
  const double through = (1.0 - f) * (1.0 - f);
  const double r = gaussian(half_angle - shift, roughness) * 0.25 * std::abs(half_azimuth) * f;
  const double tt =
      gaussian(half_angle + 0.5 * shift, 0.5 * roughness) * through * std::exp(-3.65 * turn - 3.98);
  const double trt = gaussian(half_angle + 1.5 * shift, 2.0 * roughness) * through * f *
                     std::exp(17.0 * turn - 16.78);
  return (r + tt * colour + trt * colour.square()) / (cosine * cosine);
}

Array3d HairReflectance::towards(const Vector3d& tangent, const Vector3d& light,
                                 const Vector3d& eye, const Array3d& colour) const {
  if (model_ == HairModel::even) return colour / (4.0 * pi);
  const double to_light = std::clamp(tangent.dot(light), -1.0, 1.0);
  const double to_eye = std::clamp(tangent.dot(eye), -1.0, 1.0);
  const Vector3d across_light = light - to_light * tangent, across_eye = eye - to_eye * tangent;
  const double lengths = across_light.norm() * across_eye.norm();
  const double azimuth =
      lengths > 1e-12 ? std::acos(std::clamp(across_light.dot(across_eye) / lengths, -1.0, 1.0))
                      : 0.5 * pi;
  const Array3d lobe = lobes(to_light, to_eye, azimuth, colour) / norm(to_eye);
  // Kajiya and Kay's highlight has the colour of the light, as it comes off the surface.
  return (1.0 - shine_) * sine_of(to_light) / (pi * pi) * colour + shine_ * lobe;
}

}  // namespace kappamu::forward::shells
