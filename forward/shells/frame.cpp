#include "forward/shells/frame.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::forward::shells {

using Eigen::Array4f;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

/// e^−τ is tabulated up to τ = 8; steps of 1/128 err by 8e-6 when interpolated.
constexpr int steps_per_unit = 128, deepest = 8;

}  // namespace

FrameDrawer::FrameDrawer(const HairTexture& texture, const Transfer& transfer,
                         const HairColour& colour, int width, int height)
    : texture_(texture), transfer_(transfer), colour_(colour), width_(width), height_(height) {
  if (texture.layers > 64) throw InputError("fur: a frame is drawn of at most 64 layers");
  const int n = texture.width;
  filled_.resize(static_cast<std::size_t>(n) * n);
  for (std::size_t i = 0; i < texture.size(); ++i) {
    if (texture.density[i] <= 0.0F) continue;
    const int x = static_cast<int>(i % n), y = static_cast<int>(i / n) % n;
    const std::uint64_t layer = std::uint64_t{1} << (i / n / n);
    for (const int left : {x, (x + n - 1) % n}) {
      for (const int above : {y, (y + n - 1) % n}) {
        filled_[static_cast<std::size_t>(above) * n + static_cast<std::size_t>(left)] |= layer;
      }
    }
  }
  for (int i = 0; i <= steps_per_unit * deepest + 1; ++i) {
    left_.push_back(std::exp(-static_cast<float>(i) / steps_per_unit));
  }
}

FrameDrawer::Texels FrameDrawer::lit(const PlaceLight& light, const Vector3d& eye,
                                     const HairReflectance& reflectance) const {
  Texels texels(texture_.size(), Array4f::Zero());
  const LitHair hair{texture_, transfer_, colour_, reflectance};
  for_pieces(texels.size(), 4096, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float density = texture_.density[i];
      if (density <= 0.0F) continue;
      texels[i].head<3>() = density * hair.radiance(i, light, eye).cast<float>();
      texels[i][3] = density;
    }
  });
  return texels;
}

/// Radiance, and what is left of the skin's.
Array4f FrameDrawer::seen(const Texels& lit, const Vector3f& origin,
                          const Vector3f& direction) const {
  Array4f sum(0.0F, 0.0F, 0.0F, 1.0F);
  const int n = texture_.width;
  const auto width = static_cast<float>(n), height = static_cast<float>(texture_.layer_height);
  const float slant = -1.0F / direction.z();
  const float depth = static_cast<float>(transfer_.r) * height * slant * steps_per_unit;
  const float step_x = direction.x() * slant * height, step_y = direction.y() * slant * height;
  const float first = (origin.z() - (static_cast<float>(texture_.layers) - 0.5F) * height) * slant;
  float x = origin.x() + first * direction.x() - 0.5F,
        y = origin.y() + first * direction.y() - 0.5F;
  x -= width * std::floor(x / width);
  y -= width * std::floor(y / width);
  for (int layer = texture_.layers - 1; layer >= 0; --layer) {
    while (x < 0.0F) x += width;
    while (y < 0.0F) y += width;
    while (x >= width) x -= width;
    while (y >= width) y -= width;
    const int x0 = std::min(static_cast<int>(x), n - 1), y0 = std::min(static_cast<int>(y), n - 1);
    if ((filled_[static_cast<std::size_t>(y0) * n + static_cast<std::size_t>(x0)] >> layer & 1U) !=
        0) {
      const int x1 = x0 + 1 == n ? 0 : x0 + 1, y1 = y0 + 1 == n ? 0 : y0 + 1;
      const float u = x - static_cast<float>(x0), v = y - static_cast<float>(y0);
      const Array4f met = (1 - v) * ((1 - u) * lit[texture_.texel(x0, y0, layer)] +
                                     u * lit[texture_.texel(x1, y0, layer)]) +
                          v * ((1 - u) * lit[texture_.texel(x0, y1, layer)] +
                               u * lit[texture_.texel(x1, y1, layer)]);
      if (met[3] > 0.0F) {
        const float at = std::min(depth * met[3], static_cast<float>(steps_per_unit * deepest));
        const int low = static_cast<int>(at);
        const float* pair = &left_[static_cast<std::size_t>(low)];
        const float left = pair[0] + (at - static_cast<float>(low)) * (pair[1] - pair[0]);
        const float share = sum[3] * (1.0F - left) / met[3], remaining = sum[3] * left;
        sum += share * met;
        sum[3] = remaining;
        if (remaining < 0.01F) break;
      }
    }
    x += step_x;
    y += step_y;
  }
  return sum;
}

Image<float> FrameDrawer::drawn(const Texels& lit, const Vector3d& eye, const Vector3d& target,
                                double fov_deg) const {
  const Vector3d forward = (target - eye).normalized();
  const double half = std::tan(0.5 * fov_deg * std::numbers::pi / 180.0);
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized() * half * width_ / height_;
  const Vector3d up = right.normalized().cross(forward) * half;
  Image<float> frame(width_, height_, 3);
  const Vector3f from = eye.cast<float>();
  for_rows(height_, [&](int row) {
    const double v = 1.0 - 2.0 * (row + 0.5) / height_;
    for (int column = 0; column < width_; ++column) {
      const double u = 2.0 * (column + 0.5) / width_ - 1.0;
      const Vector3f direction = (forward + u * right + v * up).normalized().cast<float>();
      if (direction.z() >= -1e-3F) continue;
      const Array4f colour = seen(lit, from, direction);
      for (int c = 0; c < 3; ++c) frame(column, row, c) = colour[c];
    }
  });
  return frame;
}

}  // namespace kappamu::forward::shells
