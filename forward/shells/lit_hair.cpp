#include "forward/shells/lit_hair.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "forward/shells/walk.h"

namespace kappamu::forward::shells {

using Eigen::Array3d;
using Eigen::Vector3d;

PlaceLight light_of(int bands, const std::vector<Lamp>& lamps) {
  PlaceLight light;
  light.lamps = lamps;
  light.coefficients =
      Eigen::MatrixXd::Zero(harmonics_in(bands), 3 + static_cast<Eigen::Index>(lamps.size()));
  for (std::size_t i = 0; i < lamps.size(); ++i) {
    light.coefficients.col(3 + static_cast<Eigen::Index>(i)) = harmonics(bands, lamps[i].direction);
  }
  return light;
}

Array3d LitHair::radiance(std::size_t texel, const PlaceLight& light, const Vector3d& eye) const {
  const Array3d own = colour.at(texture.depth[texel], texture.shade[texel]);
  const Vector3d tangent = texture.tangent[texel].cast<double>();
  const Eigen::RowVectorXd arriving = transfer.lit(texel, light.coefficients);
  Array3d sum = own * arriving.head(3).transpose().array().max(0.0) * (0.25 / std::numbers::pi);
  for (std::size_t i = 0; i < light.lamps.size(); ++i) {
    const double t = std::clamp(arriving[3 + static_cast<Eigen::Index>(i)], 0.0, 1.0);
    if (t <= 0.0) continue;
    const Lamp& lamp = light.lamps[i];
    sum += t * lamp.irradiance * reflectance.towards(tangent, lamp.direction, eye, own);
  }
  return sum;
}

Array3d LitHair::radiance_by_rays(std::size_t texel, const std::vector<Lamp>& lamps,
                                  const Vector3d& eye) const {
  const Array3d own = colour.at(texture.depth[texel], texture.shade[texel]);
  const Vector3d tangent = texture.tangent[texel].cast<double>();
  Array3d sum = Array3d::Zero();
  for (const Lamp& lamp : lamps) {
    sum += transmittance(texture, transfer.r, centre_of(texture, texel), lamp.direction) *
           lamp.irradiance * reflectance.towards(tangent, lamp.direction, eye, own);
  }
  return sum;
}

ShellTexels on_shell(const HairTexture& texture, double x, double y, int layer, Lookup lookup) {
  const auto split = [&](double at, int& low, int& high) {
    const double moved = at - 0.5 - texture.width * std::floor((at - 0.5) / texture.width);
    low = std::min(static_cast<int>(moved), texture.width - 1);
    high = low + 1 == texture.width ? 0 : low + 1;
    return moved - low;
  };
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  double u = split(x, x0, x1), v = split(y, y0, y1);
  if (lookup == Lookup::texel) {
    u = std::round(u);
    v = std::round(v);
  }
  ShellTexels met{{texture.texel(x0, y0, layer), texture.texel(x1, y0, layer),
                   texture.texel(x0, y1, layer), texture.texel(x1, y1, layer)},
                  {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v}};
  for (std::size_t i = 0; i < 4; ++i) met.density += met.weight[i] * texture.density[met.texel[i]];
  return met;
}

double opacity(const HairTexture& texture, double r, double density, double cosine) {
  return -std::expm1(-r * density * texture.layer_height / std::max(cosine, 1e-3));
}

SeenHair seen_by_shells(const HairTexture& texture, double r, const Vector3d& origin,
                        const Vector3d& direction, const TexelRadiance& radiance, Lookup lookup) {
  SeenHair seen;
  for (int layer = texture.layers - 1; layer >= 0 && seen.transmittance > 1e-3; --layer) {
    const double way = ((layer + 0.5) * texture.layer_height - origin.z()) / direction.z();
    if (way < 0.0) continue;
    const Vector3d point = origin + way * direction;
    const ShellTexels met = on_shell(texture, point.x(), point.y(), layer, lookup);
    if (met.density <= 0.0) continue;
    const auto opacity_of = [&](double density) {
      return opacity(texture, r, density, -direction.z());
    };
    Array3d light = Array3d::Zero();
    double hair = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double density = texture.density[met.texel[i]];
      const double share =
          met.weight[i] * (lookup == Lookup::opacity ? opacity_of(density) : density);
      if (share > 0.0) light += share * radiance(met.texel[i]);
      hair += share;
    }
    light /= hair;
    const double alpha = lookup == Lookup::opacity ? hair : opacity_of(met.density);
    seen.radiance += seen.transmittance * alpha * light;
    seen.transmittance *= 1.0 - alpha;
  }
  return seen;
}

SeenHair seen_by_ray(const HairTexture& texture, double r, const Vector3d& origin,
                     const Vector3d& direction, const TexelRadiance& radiance) {
  SeenHair seen;
  const double top = std::max(0.0, (texture.height() - origin.z()) / direction.z());
  Vector3d start = origin + top * direction;
  start.z() = std::min(start.z(), texture.height() * (1.0 - 1e-12));  // rounding must not lose it
  walk(texture, start, direction, false, [&](std::size_t texel, double length) {
    const double alpha = -std::expm1(-r * texture.density[texel] * length);
    if (alpha > 0.0) seen.radiance += seen.transmittance * alpha * radiance(texel);
    seen.transmittance *= 1.0 - alpha;
    return seen.transmittance > 1e-5;
  });
  return seen;
}

}  // namespace kappamu::forward::shells
