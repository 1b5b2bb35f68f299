// Which models can answer for the objects of a live scene.
#pragma once

#include <string>
#include <vector>

#include "render/scene/world.h"

namespace kappamu::render {

bool all_homogeneous(const World& world);

/// Those with the ability `live` that can answer for these objects and where their light begins:
/// first those for boxes or homogeneous objects alone, which are faster, then the others, each in
/// the registry's order.
std::vector<std::string> live_models(const World& world);

}  // namespace kappamu::render
