#include "forward/shells/transfer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/shells/walk.h"

namespace kappamu::forward::shells {

namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// Past this optical depth nothing is left: e⁻¹⁴ = 8e-7.
constexpr double opaque = 14.0;

double marched(const HairTexture& texture, double r, const Vector3d& point,
               const Vector3d& direction, bool alone) {
  if (direction.z() < 0.0) return 0.0;
  double depth = 0.0;
  walk(texture, point, direction, alone, [&](std::size_t texel, double length) {
    depth += texture.density[texel] * length;
    return r * depth < opaque;
  });
  return r * depth < opaque ? std::exp(-r * depth) : 0.0;
}

}  // namespace

std::vector<Vector3d> even_directions(int count) {
  const int orbits = 2 * std::max(1, (count + 15) / 16);  // even: none on the horizon
  std::vector<Vector3d> directions;
  for (int i = 0; i < orbits; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / orbits, across = std::sqrt(1.0 - z * z);
    const double golden = (i + 0.5) * (std::numbers::phi - 1.0);
    const double angle = 0.25 * pi * (golden - std::floor(golden));
    const double c = across * std::cos(angle), s = across * std::sin(angle);
    for (const double sx : {1.0, -1.0}) {
      for (const double sy : {1.0, -1.0}) {
        directions.emplace_back(sx * c, sy * s, z);
        directions.emplace_back(sx * s, sy * c, z);
      }
    }
  }
  return directions;
}

double transmittance(const HairTexture& texture, double r, const Vector3d& point,
                     const Vector3d& direction) {
  return marched(texture, r, point, direction, false);
}

double transmittance_alone(const HairTexture& texture, double r, const Vector3d& point,
                           const Vector3d& direction) {
  return marched(texture, r, point, direction, true);
}

Vector3d centre_of(const HairTexture& texture, std::size_t texel) {
  const auto width = static_cast<std::size_t>(texture.width);
  return {static_cast<double>(texel % width) + 0.5,
          static_cast<double>(texel / width % width) + 0.5,
          (static_cast<double>(texel / width / width) + 0.5) * texture.layer_height};
}

Transfer make_transfer(const HairTexture& texture, const TransferOptions& options,
                       Progress& progress) {
  if (options.bands < 1 || options.bands > most_bands) {
    throw InputError("fur: bands must be 1 to " + std::to_string(most_bands));
  }
  if (options.rays < 8 || options.rays > 65536) throw InputError("fur: rays must be 8 to 65536");
  if (options.r < 0.0 || !std::isfinite(options.r)) {
    throw InputError("fur: r must be positive, or 0 for the texture's own");
  }
  Transfer transfer;
  transfer.bands = options.bands;
  transfer.r = options.r > 0.0 ? options.r : texture.extinction;
  const int size = harmonics_in(options.bands);
  const std::vector<Vector3d> rays = even_directions(options.rays);
  Eigen::MatrixXd basis(size, static_cast<Eigen::Index>(rays.size()));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    basis.col(static_cast<Eigen::Index>(i)) =
        4.0 * pi / static_cast<double>(rays.size()) * harmonics(options.bands, rays[i]);
  }
  transfer.values.resize(texture.size() * static_cast<std::size_t>(size));
  const std::size_t layer = static_cast<std::size_t>(texture.width) * texture.width;
  for (int z = 0; z < texture.layers; ++z) {
    for_rows(texture.width, [&](int y) {
      for (int x = 0; x < texture.width; ++x) {
        const std::size_t texel =
            static_cast<std::size_t>(z) * layer + static_cast<std::size_t>(y) * texture.width + x;
        if (texture.density[texel] <= 0.0F) continue;
        Eigen::VectorXd values = Eigen::VectorXd::Zero(size);
        const Vector3d centre = centre_of(texture, texel);
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const double t = transmittance(texture, transfer.r, centre, rays[i]);
          if (t > 0.0) values += t * basis.col(static_cast<Eigen::Index>(i));
        }
        std::copy(values.begin(), values.end(),
                  transfer.values.begin() + static_cast<std::ptrdiff_t>(texel) * size);
      }
    });
    progress.update("fur: transfer", (z + 1.0) / texture.layers, "");
  }
  return transfer;
}

}  // namespace kappamu::forward::shells
