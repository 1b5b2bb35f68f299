#include "render/light/inner_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/triangle_mesh.h"
#include "core/random.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;
using OfChannels = std::array<std::vector<forward::Beam>, 3>;

constexpr std::uint32_t beams_of_light = 16'384, beams_of_glow = 32'768;
/// Tries to find a place inside a body that fills very little of its box.
constexpr std::uint32_t most_draws_per_beam = 4096;
/// Radius of a light, over the shortest mean free path and over the object at least: about a point
/// first collisions would have no bound, and no cubes would be fine enough.
constexpr double light_of_free_path = 0.5, light_of_size = 1.0 / 128.0;

Vector3d even_direction(double u, double v) {
  const double z = 1.0 - 2.0 * u, across = std::sqrt(std::max(0.0, 1.0 - z * z));
  const double turn = 2.0 * std::numbers::pi * v;
  return {across * std::cos(turn), across * std::sin(turn), z};
}

/// The triangle that a ray from inside flies to; none from outside.
std::optional<int> wall_ahead(const WorldObject& object, const Vector3d& from,
                              const Vector3d& direction) {
  const auto hit = object.rays->first_hit(from, direction);
  if (!hit) return std::nullopt;
  const Vector3d& normal = object.surface.normal[static_cast<std::size_t>(hit->triangle)];
  return normal.dot(direction) > 0.0 ? std::optional(hit->triangle) : std::nullopt;
}

void add(const Vector3d& from, const Vector3d& direction, int triangle, const Colour& power,
         OfChannels& beams) {
  forward::Beam beam{triangle, from, direction, 0.0};
  for (std::size_t c = 0; c < 3; ++c) {
    beam.power = power[static_cast<Eigen::Index>(c)];
    if (beam.power > 0.0) beams[c].push_back(beam);
  }
}

void add_light(const WorldObject& object, const InnerLight& light, std::uint64_t key,
               OfChannels& beams) {
  const Vector3d middle = object.world_from_object.inverse() * light.position_mm;
  double kappa = object.media.channels[0]->smallest().kappa;
  for (const auto& medium : object.media.channels) {
    kappa = std::min(kappa, medium->smallest().kappa);
  }
  const double radius = std::max(light_of_free_path * 3.0 * kappa,
                                 light_of_size * bounding_box(object.mesh).sizes().maxCoeff());
  for (std::uint32_t i = 0; i < beams_of_light; ++i) {
    const auto [u, v] = sobol_point(i, key);
    const auto [at_u, at_v] = sobol_point(i, mix(key));
    const Vector3d direction = even_direction(u, v);
    const double off = radius * std::cbrt(uniform(key_of({key, i})));
    Vector3d from = middle + off * even_direction(at_u, at_v);
    std::optional<int> triangle = wall_ahead(object, from, direction);
    if (!triangle) {  // the light reaches out of the body
      from = middle;
      triangle = wall_ahead(object, from, direction);
    }
    if (triangle) add(from, direction, *triangle, light.power / beams_of_light, beams);
  }
}

void add_glow(const WorldObject& object, std::uint64_t key, OfChannels& beams) {
  const Eigen::AlignedBox3d box = bounding_box(object.mesh);
  const Colour power = object.emission * enclosed_volume(object.mesh) / beams_of_glow;
  std::uint32_t made = 0;
  for (std::uint32_t i = 0; made < beams_of_glow && i / most_draws_per_beam < beams_of_glow; ++i) {
    const auto [x, y] = sobol_point(i, key);
    const auto [z, u] = sobol_point(i, mix(key));
    const Vector3d from = box.min() + Vector3d(x, y, z).cwiseProduct(box.sizes());
    const Vector3d direction = even_direction(u, uniform(key_of({key, i})));
    const auto triangle = wall_ahead(object, from, direction);
    if (!triangle) continue;
    add(from, direction, *triangle, power, beams);
    ++made;
  }
}

}  // namespace

std::array<std::vector<forward::Beam>, 3> inner_beams(const World& world, std::size_t index,
                                                      std::uint64_t seed) {
  const WorldObject& object = world.objects()[index];
  OfChannels beams;
  std::uint64_t number = 0;
  for (const InnerLight& light : world.inner_lights()) {
    ++number;
    if (light.object == index) add_light(object, light, key_of({seed, index, number}), beams);
  }
  if (object.emission.maxCoeff() > 0.0) add_glow(object, key_of({seed, index, 0}), beams);
  return beams;
}

}  // namespace kappamu::render
