// Shells against the integral along the eye's ray with rays to the light: light scattered once, as
// [K] counts it. Light scattered more often is followed by random walks, and shown apart.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "forward/shells/frame.h"
#include "forward/shells/walk.h"
#include "studies/record.h"
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

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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
                      {"all scattering over once", all / once}});
      save({{"rows", rows}});
    }
    progress.update("reference", static_cast<double>(rows.size()) / 8.0, light.name);
  }
}

void fur_speed(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  Json rows = Json::array();
  const auto add = [&](const std::string& step, double seconds) {
    rows.push_back({{"step", step}, {"seconds", seconds}, {"per second", 1.0 / seconds}});
    save({{"rows", rows}});
  };
  HairOptions options;
  options.seed = request.seed;
  if (quick) options.coats = {{5000, 0.10, 0.22, 0.5, 1.0, 0.3}};
  HairTexture texture;
  add("texture, " + std::to_string(quick ? 5000 : 55'000) + " hairs",
      seconds_of([&] { texture = make_hair_texture(options); }));
  Transfer transfer;
  const TransferOptions rays{5, quick ? 16 : 1024, 0.0};
  add("transfer, " + std::to_string(rays.rays) + " rays",
      seconds_of([&] { transfer = make_transfer(texture, rays, progress); }));
  const FrameDrawer drawer(texture, transfer, HairColour{}, 1280, 1024);
  const HairReflectance reflectance(HairModel::kajiya_kay);
  std::vector<double> relight, draw;
  for (int i = 0; i < (quick ? 1 : 15); ++i) {
    const double angle = 0.4 * i;
    const Lamp lamp{Vector3d(std::cos(angle), std::sin(angle), 1.0).normalized(),
                    Array3d::Constant(3.0)};
    const Vector3d eye(32.0, -70.0, 110.0), target(32.0, 32.0, 0.0);
    FrameDrawer::Texels lit;
    relight.push_back(seconds_of(
        [&] { lit = drawer.lit(light_of(5, {lamp}), (eye - target).normalized(), reflectance); }));
    Image<float> frame;
    draw.push_back(seconds_of([&] { frame = drawer.drawn(lit, eye, target, 35.0); }));
  }
  add("relight", median(relight));
  add("draw 1280 x 1024", median(draw));
  add("frame", median(relight) + median(draw));
}

}  // namespace kappamu::studies
