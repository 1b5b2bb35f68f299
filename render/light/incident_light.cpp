#include "render/light/incident_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "render/light/beam_places.h"
#include "render/light/sampling.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr std::size_t triangles_per_piece = 512;
constexpr std::size_t pieces_per_update = 32;
constexpr std::size_t most_triangles_lit_each = 1'000'000;
constexpr double environment_rays = 4e6;

class Illumination {
 public:
  Illumination(const World& world, std::size_t object, const LightSources& sources,
               const Environment* environment, std::uint64_t seed)
      : world_(world),
        object_(world.objects()[object]),
        sources_(sources),
        environment_(environment),
        key_(key_of({seed, object})) {
    double kappa = object_.media.channels[0]->smallest().kappa;
    for (const auto& medium : object_.media.channels) {
      kappa = std::min(kappa, medium->smallest().kappa);
    }
    const double free_path = 3.0 * kappa;
    const double size = bounding_box(object_.mesh).sizes().maxCoeff();
    const double spacing = std::max(0.5 * free_path, size / 256.0);
    area_per_beam_ = spacing * spacing;
    const double rays = environment_rays / static_cast<double>(object_.surface.size());
    environment_pairs_ = static_cast<std::uint32_t>(std::clamp(0.5 * rays, 8.0, 512.0));
  }

  void add_beams(std::size_t triangle, BeamsOfChannels& out) const;
  Colour environment_irradiance(std::size_t triangle) const;

 private:
  Vector3d world_normal(std::size_t triangle) const {
    return object_.world_from_object.rotation * object_.surface.normal[triangle];
  }

  /// One direction of the environment from a point, weighted by the balance heuristic.
  Colour environment_term(const Vector3d& point, const Vector3d& normal, const Vector3d& direction,
                          const Colour& radiance, double density) const {
    const double cosine = direction.dot(normal);
    if (cosine <= 0.0 || radiance.maxCoeff() <= 0.0) return Colour::Zero();
    if (world_.blocked(point, direction, std::numeric_limits<double>::infinity())) {
      return Colour::Zero();
    }
    return radiance * cosine / (density + cosine / std::numbers::pi);
  }

  const World& world_;
  const WorldObject& object_;
  const LightSources& sources_;
  const Environment* environment_;
  std::uint64_t key_;
  double area_per_beam_ = 1.0;
  std::uint32_t environment_pairs_ = 0;
};

void Illumination::add_beams(std::size_t triangle, BeamsOfChannels& out) const {
  const double area = object_.surface.area[triangle];
  if (area <= 0.0) return;
  const std::uint64_t key = key_of({key_, triangle});
  const double wanted = area / area_per_beam_;
  auto count = static_cast<std::uint32_t>(std::ceil(wanted));
  double area_each = area / static_cast<double>(count);
  if (object_.surface.size() > most_triangles_lit_each && wanted < 1.0) {
    if (uniform(key_of({key, 1})) > wanted) return;
    area_each = area_per_beam_;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto [u, v] = sobol_point(i, key);
    kappamu::render::add_beams(world_, object_, sources_,
                               {static_cast<int>(triangle), point_on(object_.mesh, triangle, u, v),
                                area_each * object_.surface.normal[triangle]},
                               out);
  }
}

Colour Illumination::environment_irradiance(std::size_t triangle) const {
  const std::uint64_t key = key_of({key_, triangle, 2});
  const Vector3d normal = world_normal(triangle);
  Colour sum = Colour::Zero();
  for (std::uint32_t i = 0; i < environment_pairs_; ++i) {
    const auto [on_u, on_v] = sobol_point(i, key);
    const auto [bright_u, bright_v] = sobol_point(i, mix(key));
    const auto [even_u, even_v] = sobol_point(i, mix(mix(key)));
    const Vector3d point = object_.world_from_object * point_on(object_.mesh, triangle, on_u, on_v);
    if (!environment_->even()) {
      const Environment::Sample bright = environment_->sample(bright_u, bright_v);
      sum += environment_term(point, normal, bright.direction, bright.radiance, bright.density);
    }
    const Vector3d direction = cosine_direction(normal, even_u, even_v);
    sum += environment_term(point, normal, direction, environment_->radiance(direction),
                            environment_->density(direction));
  }
  return sum / static_cast<double>(environment_pairs_);
}

}  // namespace

IncidentLight incident_light(const World& world, std::size_t object, const LightSources& sources,
                             const Environment* environment, std::uint64_t seed,
                             Progress& progress) {
  const std::size_t triangles = world.objects()[object].surface.size();
  const std::vector<double>& area = world.objects()[object].surface.area;
  const Illumination illumination(world, object, sources, environment, seed);
  IncidentLight light;
  if (environment) {
    for (forward::ObjectLight& channel : light.channels) channel.diffuse.assign(triangles, 0.0);
  }
  // Beams by pieces, put together in the triangles' order on any number of threads.
  const std::size_t pieces = (triangles + triangles_per_piece - 1) / triangles_per_piece;
  std::vector<BeamsOfChannels> beams(pieces);
  const auto light_piece = [&](std::size_t piece) {
    const std::size_t begin = piece * triangles_per_piece;
    for (std::size_t t = begin; t < std::min(triangles, begin + triangles_per_piece); ++t) {
      if (!sources.empty()) illumination.add_beams(t, beams[piece]);
      if (!environment) continue;
      const Colour irradiance = illumination.environment_irradiance(t);
      for (std::size_t c = 0; c < 3; ++c) {
        light.channels[c].diffuse[t] = irradiance[static_cast<Eigen::Index>(c)];
      }
    }
  };
  for (std::size_t first = 0; first < pieces; first += pieces_per_update) {
    const std::size_t count = std::min(pieces_per_update, pieces - first);
    for_rows(static_cast<int>(count),
             [&](int row) { light_piece(first + static_cast<std::size_t>(row)); });
    progress.update("incident light",
                    static_cast<double>(first + count) / static_cast<double>(pieces), "");
  }
  for (std::size_t c = 0; c < 3; ++c) {
    forward::ObjectLight& channel = light.channels[c];
    double power = 0.0;
    for (BeamsOfChannels& piece : beams) {
      channel.beams.insert(channel.beams.end(), piece[c].begin(), piece[c].end());
      piece[c] = {};
    }
    for (const forward::Beam& beam : channel.beams) power += beam.power;
    for (std::size_t t = 0; t < channel.diffuse.size(); ++t) power += channel.diffuse[t] * area[t];
    light.power[static_cast<Eigen::Index>(c)] = power;
  }
  return light;
}

}  // namespace kappamu::render
