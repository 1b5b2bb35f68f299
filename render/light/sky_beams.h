// Beams of an environment's lamps, which enter bodies along their own directions. Taken as even
// light, a wide lamp behind a body makes a picture 4 to 6 % too dark (docs/gallery.md, "Beside
// Mitsuba").
#pragma once

#include <span>

#include "render/light/beam_places.h"
#include "render/light/environment.h"

namespace kappamu::render {

/// At each place, what arrives is the mean over `draws` directions, most_draws_of_sky at most,
/// drawn by brightness; it travels along `beams_of_sky` of them, chosen by what they bring.
std::array<forward::ObjectLight, 3> sky_beams_at(const World& world, std::size_t object,
                                                 const Environment& environment,
                                                 std::span<const BeamPlace> places,
                                                 std::uint32_t draws, std::uint64_t seed);

/// Of a place.
inline constexpr int beams_of_sky = 2;
inline constexpr std::uint32_t most_draws_of_sky = 64;

}  // namespace kappamu::render
