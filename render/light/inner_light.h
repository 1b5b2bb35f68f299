// Light that begins inside objects: point lights within a body ([M] 6: a candle's flame) and
// bodies that glow.
#pragma once

#include <array>
#include <cstdint>

#include "forward/object_model.h"
#include "render/scene/world.h"

namespace kappamu::render {

/// Beams of the lights in an object and of its own emission, R, G, B, in the object's frame. A
/// light is a ball of half a mean free path and sends 16,384 from even places in it. A body that
/// glows sends 32,768 from even places in it. Of low discrepancy, unbiased over `seed`.
std::array<std::vector<forward::Beam>, 3> inner_beams(const World& world, std::size_t object,
                                                      std::uint64_t seed);

}  // namespace kappamu::render
