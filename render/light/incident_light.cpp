#include "render/light/incident_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/optics.h"
#include "core/parallel.h"
#include "core/random.h"
#include "render/light/inner_light.h"
#include "render/light/sampling.h"
#include "render/light/sky_beams.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr std::size_t triangles_per_update = 16'384, places_per_update = 131'072;
constexpr std::size_t triangles_per_piece = 512;
/// Pairs of directions from a triangle; a preview does with fewer.
constexpr double least_pairs = 8.0, least_pairs_of_preview = 2.0, most_pairs = 512.0;
/// Directions of lamps from a place.
constexpr double least_draws = 16.0, least_draws_of_preview = 4.0, most_draws = most_draws_of_sky;
/// Of places: their distance over the shortest mean free path, and over the object at least; that
/// of places which small triangles share, over it.
constexpr double of_free_path = 0.35, of_size = 1.0 / 256.0, shared = 1.0 / 3.0;

BeamSpacing spacing_on(const WorldObject& object) {
  double kappa = object.media.channels[0]->smallest().kappa;
  for (const auto& medium : object.media.channels) {
    kappa = std::min(kappa, medium->smallest().kappa);
  }
  const double size = bounding_box(object.mesh).sizes().maxCoeff();
  const double spacing = std::max(of_free_path * 3.0 * kappa, of_size * size);
  return {spacing, shared * spacing};
}

/// Light that surfaces have mirrored more often is left out: 2e-5 of what enters a bowl of η = 1.4,
/// less elsewhere (tests/render/concave_environment_test.cpp).
constexpr int most_reflections = 4;

/// The environment's light on a triangle, before Fresnel: what arrives from the sky itself, and the
/// even light of which as much would enter of that and of what surfaces mirror of the sky. Where
/// the horizon is hidden less is reflected than of even light.
struct Received {
  Colour arriving = Colour::Zero(), as_even = Colour::Zero();
};

/// What triangles receive of the environment.
class Surroundings {
 public:
  Surroundings(const World& world, std::size_t object, const Environment& environment,
               std::uint64_t seed, double rays)
      : world_(world),
        object_(world.objects()[object]),
        environment_(environment),
        key_(key_of({seed, object})) {
    const double pairs = 0.5 * rays / static_cast<double>(object_.surface.size());
    const double least = rays < environment_rays ? least_pairs_of_preview : least_pairs;
    pairs_ = static_cast<std::uint32_t>(std::clamp(pairs, least, most_pairs));
    const BoundaryConstants& boundary = object_.boundary;
    transmitted_of_even_ = boundary.eta * boundary.eta * (1.0 - boundary.r_phi);
  }

  Received received(std::size_t triangle) const;

 private:
  double transmitted(const Vector3d& normal, const Vector3d& direction) const {
    const double cosine = std::clamp(direction.dot(normal), 0.0, 1.0);
    return (1.0 - fresnel_external(object_.boundary.eta, cosine)) / transmitted_of_even_;
  }
  /// The sky's radiance that surfaces mirror towards a point, `hit` being the first; as of smooth
  /// surfaces, whatever their roughness.
  Colour mirrored(WorldHit hit, Vector3d direction) const {
    double share = 1.0;
    for (int reflection = 0; reflection < most_reflections; ++reflection) {
      const double cosine = -direction.dot(hit.normal);
      if (cosine <= 0.0) break;  // rounding at an edge: from inside
      share *= fresnel_external(world_.objects()[hit.object].boundary.eta, cosine);
      direction += 2.0 * cosine * hit.normal;
      const auto next = world_.first_hit(hit.position, direction, world_.skin());
      if (!next) return share * environment_.radiance(direction);
      hit = *next;
    }
    return Colour::Zero();
  }
  /// Adds one direction from a point, weighted by the balance heuristic.
  void add(const Vector3d& point, const Vector3d& normal, const Vector3d& direction,
           const Colour& radiance, double density, Received& sum) const {
    const double cosine = direction.dot(normal);
    if (cosine <= 0.0) return;
    const double weight = cosine / (density + cosine / std::numbers::pi) / pairs_;
    const auto hit = world_.first_hit(point, direction, world_.skin());
    Colour seen = hit ? mirrored(*hit, direction) : radiance;
    if (!hit && environment_.has_beams()) seen -= environment_.of_lamps(direction);
    if (!hit) sum.arriving += weight * seen;
    sum.as_even += weight * transmitted(normal, direction) * seen;
  }

  const World& world_;
  const WorldObject& object_;
  const Environment& environment_;
  std::uint64_t key_;
  std::uint32_t pairs_ = 0;
  double transmitted_of_even_ = 1.0;
};

Received Surroundings::received(std::size_t triangle) const {
  const std::uint64_t key = key_of({key_, triangle, 2});
  const Vector3d normal = object_.world_from_object.rotation * object_.surface.normal[triangle];
  Received sum;
  double of_all = 0.0;
  for (std::uint32_t i = 0; i < pairs_; ++i) {
    const auto [on_u, on_v] = sobol_point(i, key);
    const auto [bright_u, bright_v] = sobol_point(i, mix(key));
    const auto [even_u, even_v] = sobol_point(i, mix(mix(key)));
    const Vector3d point = object_.world_from_object * point_on(object_.mesh, triangle, on_u, on_v);
    if (!environment_.even()) {
      const Environment::Sample bright = environment_.sample(bright_u, bright_v);
      add(point, normal, bright.direction, bright.radiance, bright.density, sum);
    }
    const Vector3d direction = cosine_direction(normal, even_u, even_v);
    add(point, normal, direction, environment_.radiance(direction), environment_.density(direction),
        sum);
    of_all += transmitted(normal, direction) / pairs_;
  }
  // Even light keeps no noise where nothing is in the way.
  if (environment_.even()) sum.as_even /= of_all;
  return sum;
}

/// Calls work(begin, end) for all of [0, size) in steps, each followed by an update.
template <class Work>
void in_steps(std::size_t size, std::size_t step, Progress& progress, const Work& work) {
  for (std::size_t begin = 0; begin < size; begin += step) {
    const std::size_t end = std::min(size, begin + step);
    work(begin, end);
    progress.update("incident light", static_cast<double>(end) / static_cast<double>(size), "");
  }
}

}  // namespace

std::vector<BeamPlace> incident_places(const WorldObject& object) {
  return beam_places(object, spacing_on(object));
}

DiffuseLight diffuse_light(const World& world, std::size_t object, const Environment& environment,
                           std::uint64_t seed, Progress& progress, double rays) {
  const WorldObject& lit = world.objects()[object];
  const std::size_t triangles = lit.surface.size();
  std::vector<Colour> arriving(triangles);
  const Surroundings surroundings(world, object, environment, seed, rays);
  DiffuseLight light;
  for (std::vector<double>& channel : light.irradiance) channel.assign(triangles, 0.0);
  in_steps(triangles, triangles_per_update, progress, [&](std::size_t first, std::size_t last) {
    for_pieces(last - first, triangles_per_piece,
               [&](std::size_t, std::size_t begin, std::size_t end) {
                 for (std::size_t t = first + begin; t < first + end; ++t) {
                   const Received received = surroundings.received(t);
                   arriving[t] = received.arriving;
                   for (std::size_t c = 0; c < 3; ++c) {
                     light.irradiance[c][t] = received.as_even[static_cast<Eigen::Index>(c)];
                   }
                 }
               });
  });
  for (std::size_t t = 0; t < triangles; ++t) light.power += arriving[t] * lit.surface.area[t];
  return light;
}

BeamsOfChannels beams_of_lights(const World& world, std::size_t object, const LightSources& sources,
                                const Environment* environment, std::span<const BeamPlace> places,
                                std::uint64_t seed, Progress& progress, double rays) {
  BeamsOfChannels beams;
  const bool sky = environment != nullptr && environment->has_beams();
  if (sources.empty() && !sky) return beams;
  const double least = rays < environment_rays ? least_draws_of_preview : least_draws;
  const auto draws = static_cast<std::uint32_t>(std::clamp(
      rays / static_cast<double>(std::max<std::size_t>(1, places.size())), least, most_draws));
  const auto add = [&](const std::array<forward::ObjectLight, 3>& some) {
    for (std::size_t c = 0; c < 3; ++c) {
      beams[c].insert(beams[c].end(), some[c].beams.begin(), some[c].beams.end());
    }
  };
  in_steps(places.size(), places_per_update, progress, [&](std::size_t begin, std::size_t end) {
    const auto here = places.subspan(begin, end - begin);
    if (!sources.empty()) add(beams_at(world, object, sources, here));
    if (sky) add(sky_beams_at(world, object, *environment, here, draws, key_of({seed, begin})));
  });
  return beams;
}

IncidentLight incident_light(const World& world, std::size_t object, const LightSources& sources,
                             const Environment* environment, std::uint64_t seed,
                             Progress& progress) {
  IncidentLight light;
  if (environment != nullptr) {
    DiffuseLight diffuse =
        diffuse_light(world, object, *environment, seed, progress, environment_rays);
    light.power = diffuse.power;
    for (std::size_t c = 0; c < 3; ++c) {
      light.channels[c].diffuse = std::move(diffuse.irradiance[c]);
    }
  }
  const std::vector<BeamPlace> places = incident_places(world.objects()[object]);
  BeamsOfChannels outer = beams_of_lights(world, object, sources, environment, places, seed,
                                          progress, environment_rays);
  const BeamsOfChannels inner = inner_beams(world, object, seed);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<forward::Beam>& beams = light.channels[c].beams;
    beams = std::move(outer[c]);
    beams.insert(beams.end(), inner[c].begin(), inner[c].end());
    for (const forward::Beam& beam : beams) {
      light.power[static_cast<Eigen::Index>(c)] += beam.power;
    }
  }
  return light;
}

}  // namespace kappamu::render
