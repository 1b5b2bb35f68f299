#include "render/light/sky_beams.h"

#include <limits>

#include "core/parallel.h"
#include "core/random.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr std::size_t places_of_sky_per_piece = 256;

struct Drawn {
  Vector3d direction;  ///< of travel, in the object's frame
  double power = 0.0;  ///< in luminance, not normalised
};

void add_sky_beams(const World& world, const WorldObject& object, const Environment& environment,
                   const BeamPlace& place, std::uint32_t draws, std::uint64_t key,
                   std::array<forward::ObjectLight, 3>& out) {
  const Vector3d point = object.world_from_object * place.position;
  const Vector3d& normal = object.surface.normal[static_cast<std::size_t>(place.triangle)];
  std::array<Drawn, most_draws_of_sky> arriving;
  std::size_t count = 0;
  Colour power = Colour::Zero();
  double sum = 0.0;
  for (std::uint32_t i = 0; i < draws; ++i) {
    const auto [u, v] = sobol_point(i, key);
    const Environment::Sample sample = environment.sample(u, v);
    const Vector3d direction = object.world_from_object.rotation.transpose() * -sample.direction;
    const double area = -direction.dot(place.area);
    if (!(area > 0.0) || direction.dot(normal) >= 0.0) continue;
    if (world.blocked(point, sample.direction, std::numeric_limits<double>::infinity())) continue;
    const Colour here = environment.of_lamps(sample.direction) * (area / sample.density / draws);
    arriving[count++] = {direction, luminance(here)};
    power += here;
    sum += luminance(here);
  }
  const double step = sum / beams_of_sky;
  double next = uniform(mix(key)) * step, passed = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    passed += arriving[i].power;
    forward::Beam beam{place.triangle, place.position, arriving[i].direction, 0.0};
    double chosen = 0.0;
    for (; next < passed; next += step) chosen += 1.0 / beams_of_sky;
    for (std::size_t c = 0; c < 3; ++c) {
      beam.power = chosen * power[static_cast<Eigen::Index>(c)];
      if (beam.power > 0.0) out[c].beams.push_back(beam);
    }
  }
}

}  // namespace

std::array<forward::ObjectLight, 3> sky_beams_at(const World& world, std::size_t object,
                                                 const Environment& environment,
                                                 std::span<const BeamPlace> places,
                                                 std::uint32_t draws, std::uint64_t seed) {
  std::vector<std::array<forward::ObjectLight, 3>> some(
      pieces(places.size(), places_of_sky_per_piece));
  for_pieces(places.size(), places_of_sky_per_piece,
             [&](std::size_t piece, std::size_t begin, std::size_t end) {
               for (std::size_t i = begin; i < end; ++i) {
                 add_sky_beams(world, world.objects()[object], environment, places[i], draws,
                               key_of({seed, object, i}), some[piece]);
               }
             });
  std::array<forward::ObjectLight, 3> light;
  for (const auto& of_piece : some) {
    for (std::size_t c = 0; c < 3; ++c) {
      light[c].beams.insert(light[c].beams.end(), of_piece[c].beams.begin(),
                            of_piece[c].beams.end());
    }
  }
  return light;
}

}  // namespace kappamu::render
