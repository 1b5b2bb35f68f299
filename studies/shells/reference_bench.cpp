// Shells against the integral along the eye's ray with rays to the light: light scattered once, as
// [K] counts it. Light scattered more often is followed by random walks, and shown apart.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "forward/shells/walk.h"
#include "studies/shells/shells_bench.h"

namespace kappamu::studies {

using namespace forward::shells;
using Eigen::Array3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

constexpr double albedo = 0.8;

Vector3d even_direction(double u, double v) {
  const double z = 2.0 * u - 1.0, across = std::sqrt(1.0 - z * z);
  return {across * std::cos(2.0 * pi * v), across * std::sin(2.0 * pi * v), z};
}

/// ∫ L T dω of every texel with hair, by rays that no transfer has used.
std::vector<double> fluence_by_rays(const HairTexture& texture, double r, const SkyLight& light,
                                    std::uint32_t rays) {
  std::vector<double> fluence(texture.size());
  const int slice = texture.width * texture.width;
  for_rows(static_cast<int>(texture.size()) / slice, [&](int z) {
    for (int i = z * slice; i < (z + 1) * slice; ++i) {
      const auto texel = static_cast<std::size_t>(i);
      if (texture.density[texel] <= 0.0F) continue;
      double sum = 0.0;
      for (std::uint32_t k = 0; k < rays; ++k) {
        const auto [u, v] = sobol_point(k, 777 + texel);
        const Vector3d d = even_direction(0.5 + 0.5 * u, v);  // the upper half alone
        sum += light.radiance(d) * transmittance(texture, r, centre_of(texture, texel), d);
      }
      fluence[texel] = sum * 2.0 * pi / rays;
    }
  });
  return fluence;
}

/// Radiance scattered once and in all along one eye's ray; isotropic, albedo as above.
struct Walked {
  double once = 0.0, all = 0.0;
};
Walked walked(const HairTexture& texture, double r, const SkyLight& light, Vector3d from,
              Vector3d direction, std::uint64_t key) {
  Walked sum;
  double weight = 1.0;
  for (std::uint64_t bounce = 0; bounce < 64; ++bounce) {
    const auto random = [&](std::uint64_t i) { return uniform(key_of({key, bounce, i})); };
    double depth = -std::log(random(0)) / r, way = 0.0;
    bool met = false;
    walk(texture, from, direction, false, [&](std::size_t texel, double length) {
      const double here = texture.density[texel] * length;
      met = here >= depth;
      way += met ? depth / texture.density[texel] : length;
      if (!met) depth -= here;
      return !met;
    });
    if (!met) return sum;
    from += way * direction;
    from.z() = std::clamp(from.z(), 0.0, texture.height() * (1.0 - 1e-12));
    weight *= albedo;
    const Vector3d lit = even_direction(0.5 + 0.5 * random(1), random(2));
    const double arriving = 0.5 * light.radiance(lit) * transmittance(texture, r, from, lit);
    sum.all += weight * arriving;
    if (bounce == 0) sum.once = weight * arriving;
    direction = even_direction(random(3), random(4));
  }
  return sum;
}

/// Σ|a − b| / Σ b over blocks of pixels of the first channel.
double picture_error(const Image<float>& seen, const Image<float>& truth, int block) {
  double difference = 0.0, sum = 0.0;
  for (int y = 0; y + block <= truth.height(); y += block) {
    for (int x = 0; x + block <= truth.width(); x += block) {
      double d = 0.0;
      for (int j = 0; j < block; ++j) {
        for (int i = 0; i < block; ++i) {
          d += seen(x + i, y + j) - truth(x + i, y + j);
          sum += truth(x + i, y + j);
        }
      }
      difference += std::abs(d);
    }
  }
  return difference / sum;
}

}  // namespace

void fur_reference(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  HairOptions options;
  options.seed = request.seed;
  if (quick) {
    options.width = options.layers = 12;
    options.coats = {{800, 0.04, 0.10, 0.1, 0.45, 0.3}, {120, 0.10, 0.22, 0.5, 1.0, 0.3}};
  }
  const HairTexture texture = make_hair_texture(options);
  const Transfer transfer = make_transfer(texture, {5, quick ? 64 : 1024, 0.0}, progress);
  const double tile = options.width, r = transfer.r;
  const FlatView from_above{{0.5 * tile, -1.3 * tile, 2.5 * tile},
                            {0.5 * tile, 0.5 * tile, 0.0},
                            20.0,
                            quick ? 32 : 160,
                            quick ? 32 : 128,
                            quick ? 1 : 16};
  FlatView grazing = from_above;
  grazing.eye = {0.5 * tile, -3.0 * tile, 0.9 * tile};
  Json rows = Json::array();
  for (const SkyLight& light : four_lights()) {
    const std::vector<double> exact = fluence_by_rays(texture, r, light, quick ? 32 : 192);
    const Eigen::MatrixXd coefficients = projected(light, 5);
    const auto of = [](double fluence) -> Array3d {
      return Array3d::Constant(albedo * 0.25 / pi * std::max(0.0, fluence));
    };
    std::vector<double> projected_light(texture.size());
    for (std::size_t i = 0; i < texture.size(); ++i) {
      if (texture.density[i] > 0.0F) projected_light[i] = transfer.lit(i, coefficients)[0];
    }
    const TexelRadiance by_transfer = [&](std::size_t texel) { return of(projected_light[texel]); };
    const TexelRadiance by_rays = [&](std::size_t texel) { return of(exact[texel]); };
    for (const FlatView& view : {from_above, grazing}) {
      const auto by_shells = [&](const TexelRadiance& radiance, Lookup lookup) {
        return flat_picture(view, [&](const Vector3d& origin, const Vector3d& direction) {
          return seen_by_shells(texture, r, origin, direction, radiance, lookup);
        });
      };
      const Image<float> truth = flat_picture(view, [&](const Vector3d& o, const Vector3d& d) {
        return seen_by_ray(texture, r, o, d, by_rays);
      });
      const Image<float> shells = by_shells(by_transfer, Lookup::texel);
      const Image<float> drawn_alone = by_shells(by_rays, Lookup::texel);
      const Image<float> smooth = by_shells(by_transfer, Lookup::smooth);
      const Image<float> opacity = by_shells(by_transfer, Lookup::opacity);
      double once = 0.0, all = 0.0;
      const std::uint32_t walks = quick ? 200 : 40'000;
      const Vector3d down = (view.target - view.eye).normalized();
      for (std::uint32_t k = 0; k < walks; ++k) {
        const auto [u, v] = sobol_point(k, 31);
        const Walked sum = walked(texture, r, light, {tile * u, tile * v, texture.height()}, down,
                                  key_of({request.seed, k}));
        once += sum.once;
        all += sum.all;
      }
      rows.push_back({{"light", light.name},
                      {"view", view.eye.z() < tile ? "grazing" : "above"},
                      {"error of pixels", picture_error(shells, truth, 1)},
                      {"of blocks of 16", picture_error(shells, truth, 16)},
                      {"of shells alone, blocks", picture_error(drawn_alone, truth, 16)},
                      {"of smooth lookup, blocks", picture_error(smooth, truth, 16)},
                      {"of lookup between opacities, blocks", picture_error(opacity, truth, 16)},
                      {"all scattering over once", all / once}});
      save({{"rows", rows}});
    }
    progress.update("reference", static_cast<double>(rows.size()) / 8.0, light.name);
  }
}

}  // namespace kappamu::studies
