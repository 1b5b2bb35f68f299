#include "report/drawing/cutaway.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/optics.h"
#include "report/drawing/picture.h"

namespace kappamu::report {

namespace {

using Eigen::Vector3d;

/// What lies beside the block: the verdict's background.
constexpr std::array<std::uint8_t, 3> page{250, 251, 252};
/// Along which the viewer looks.
const Vector3d gaze = Vector3d(-0.55, 0.5, 1.0).normalized();
/// Light from the viewer's left makes faces differ, by the axis across them.
constexpr std::array<double, 3> shade{0.62, 0.85, 1.0};

/// Diffuse reflectance of a half space (Flock et al. 1992, equation 5): a' its reduced albedo, A as
/// in core/optics.h.
double reflectance(double kappa, double mu, double A) {
  const double albedo = std::clamp(1.0 - 3.0 * kappa * mu, 0.0, 1.0), lost = 1.0 - albedo;
  return albedo / (1.0 + 2.0 * A * lost + (1.0 + 2.0 * A / 3.0) * std::sqrt(3.0 * lost));
}

struct Hit {
  std::array<int, 3> voxel;
  int axis;  ///< across the face that is seen
};

/// The first voxel outside the octant that is cut away; lengths in voxels, from the block's corner.
std::optional<Hit> first_voxel(const GridShape& shape, const Vector3d& from) {
  double near = 0.0, far = std::numeric_limits<double>::infinity();
  int axis = 2;
  for (int k = 0; k < 3; ++k) {
    const double one = -from[k] / gaze[k], other = (shape.extent(k) - from[k]) / gaze[k];
    if (std::min(one, other) > near) {
      near = std::min(one, other);
      axis = k;
    }
    far = std::min(far, std::max(one, other));
  }
  while (near < far) {
    const Vector3d inside = from + (near + 1e-9) * gaze;
    std::array<int, 3> voxel{};
    double next = far;
    int next_axis = axis;
    for (int k = 0; k < 3; ++k) {
      const int i = std::clamp(static_cast<int>(std::floor(inside[k])), 0, shape.extent(k) - 1);
      voxel[static_cast<std::size_t>(k)] = i;
      const double leaves = (i + (gaze[k] > 0.0 ? 1.0 : 0.0) - from[k]) / gaze[k];
      if (leaves < next) {
        next = leaves;
        next_axis = k;
      }
    }
    const bool cut =
        2 * voxel[0] + 1 > shape.nx && 2 * voxel[1] + 1 < shape.ny && 2 * voxel[2] + 1 < shape.nz;
    if (!cut) return Hit{voxel, axis};
    near = std::max(next, near + 1e-9);
    axis = next_axis;
  }
  return std::nullopt;
}

}  // namespace

Image<std::uint8_t> cutaway(const std::vector<Medium>& channels, double eta, int width) {
  const GridShape& shape = channels.front().kappa.shape();
  const Vector3d size(shape.nx, shape.ny, shape.nz);
  const Vector3d down = (Vector3d::UnitY() - gaze.y() * gaze).normalized(),
                 right = down.cross(gaze);
  const Vector3d half(right.cwiseAbs().dot(size) / 2.0, down.cwiseAbs().dot(size) / 2.0, 0.0);
  const int height = std::max(1, static_cast<int>(std::lround(width * half.y() / half.x())));
  const double A = boundary_constants(eta).A;
  const auto colour_of = [&](const Hit& hit, std::size_t channel) {
    const Medium& medium = channels[channels.size() < 3 ? 0 : channel];
    const auto [x, y, z] = hit.voxel;
    return reflectance(medium.kappa(x, y, z), medium.mu(x, y, z), A);
  };
  Image<float> light(width, height, 3);
  std::vector<float> seen;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double u = (2.0 * (column + 0.5) / width - 1.0) * half.x();
      const double v = (2.0 * (row + 0.5) / height - 1.0) * half.y();
      const auto hit =
          first_voxel(shape, 0.5 * size + u * right + v * down - 2.0 * size.norm() * gaze);
      for (std::size_t c = 0; c < 3; ++c) {
        double value = -1.0;
        if (hit) value = shade[static_cast<std::size_t>(hit->axis)] * colour_of(*hit, c);
        light(column, row, static_cast<int>(c)) = static_cast<float>(value);
        if (hit) seen.push_back(static_cast<float>(value));
      }
    }
  }
  Image<std::uint8_t> image = tone_mapped(light, std::max(quantile(std::move(seen), 0.99), 1e-6));
  for (std::size_t i = 0; i < light.values().size(); ++i) {
    if (light.values()[i] < 0.0F) image.values()[i] = page[i % 3];
  }
  return image;
}

}  // namespace kappamu::report
