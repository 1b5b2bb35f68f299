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

/// The way from the centre of a layer's texel to the open: the same from all of its texels, but for
/// where it begins.
struct Step {
  int x = 0, y = 0, z = 0;  ///< texels from the first; x and y wrapped
  float length = 0.0F;      ///< [texel]
};
std::vector<Step> way_from_centre(const HairTexture& texture, const Vector3d& direction) {
  // An empty volume of the same shape: the walk goes on until it leaves by the top.
  std::vector<Step> steps;
  const auto width = static_cast<std::size_t>(texture.width);
  walk(texture, centre_of(texture, 0), direction, false, [&](std::size_t texel, double length) {
    steps.push_back({static_cast<int>(texel % width), static_cast<int>(texel / width % width),
                     static_cast<int>(texel / width / width), static_cast<float>(length)});
    return true;
  });
  return steps;
}

/// Densities with each row twice, so that a row that begins anywhere lies in one piece.
std::vector<float> doubled_rows(const HairTexture& texture) {
  const auto width = static_cast<std::size_t>(texture.width);
  std::vector<float> rows(2 * texture.size());
  for (std::size_t row = 0; row < texture.size() / width; ++row) {
    for (const std::size_t half : {0, 1}) {
      std::copy_n(texture.density.begin() + static_cast<std::ptrdiff_t>(row * width), width,
                  rows.begin() + static_cast<std::ptrdiff_t>((2 * row + half) * width));
    }
  }
  return rows;
}

/// Optical depths, over r, of one row of texels along one way; stops where all are opaque.
void march_row(const HairTexture& texture, const std::vector<float>& rows, int y, int z,
               const std::vector<Step>& way, float most, Eigen::ArrayXf& depth) {
  const int width = texture.width;
  depth.setZero();
  int count = 0;
  for (const Step& step : way) {
    const int layer = z + step.z;
    if (layer >= texture.layers) return;
    const int row = y + step.y < width ? y + step.y : y + step.y - width;
    depth +=
        step.length *
        Eigen::Map<const Eigen::ArrayXf>(
            rows.data() + 2 * (static_cast<std::ptrdiff_t>(layer) * width + row) * width + step.x,
            width);
    if (++count % 8 == 0 && depth.minCoeff() > most) return;
  }
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
  std::vector<Vector3d> rays = even_directions(options.rays);
  const double share = 4.0 * pi / static_cast<double>(rays.size());
  std::erase_if(rays, [](const Vector3d& ray) { return ray.z() < 0.0; });  // the skin is there
  const auto count = static_cast<Eigen::Index>(rays.size());
  Eigen::MatrixXd basis(count, size);
  std::vector<std::vector<Step>> ways(rays.size());
  for_rows(static_cast<int>(count), [&](int i) {
    const auto ray = static_cast<std::size_t>(i);
    basis.row(i) = share * harmonics(options.bands, rays[ray]).transpose();
    ways[ray] = way_from_centre(texture, rays[ray]);
  });
  const std::vector<float> rows = doubled_rows(texture);
  const auto r = static_cast<float>(transfer.r), most = static_cast<float>(opaque / transfer.r);
  transfer.values.resize(texture.size() * static_cast<std::size_t>(size));
  for (int z = 0; z < texture.layers; ++z) {
    for_rows(texture.width, [&](int y) {
      const std::size_t first = texture.texel(0, y, z);
      const auto width = static_cast<std::size_t>(texture.width);
      const auto hair = [&](std::size_t x) { return texture.density[first + x] > 0.0F; };
      Eigen::ArrayXf depth(texture.width);
      Eigen::MatrixXd through(texture.width, count);
      bool any = false;
      for (std::size_t x = 0; x < width; ++x) any = any || hair(x);
      if (!any) return;
      for (Eigen::Index i = 0; i < count; ++i) {
        march_row(texture, rows, y, z, ways[static_cast<std::size_t>(i)], most, depth);
        through.col(i) = (depth > most).select(0.0F, (-r * depth).exp()).cast<double>();
      }
      const Eigen::MatrixXd values = through * basis;
      for (std::size_t x = 0; x < width; ++x) {
        if (!hair(x)) continue;
        for (int k = 0; k < size; ++k) {
          transfer
              .values[(first + x) * static_cast<std::size_t>(size) + static_cast<std::size_t>(k)] =
              static_cast<float>(values(static_cast<Eigen::Index>(x), k));
        }
      }
    });
    progress.update("fur: transfer", (z + 1.0) / texture.layers, "");
  }
  return transfer;
}

}  // namespace kappamu::forward::shells
