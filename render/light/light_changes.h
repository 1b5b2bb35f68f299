// From the lights of a scene to those lights turned, moved and coloured, and back.
#pragma once

#include <string>
#include <vector>

#include "render/edit/light_change.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// Those that make `after` of `before`, which are the same kinds in the same order.
LightChanges light_changes(const std::vector<Light>& before, const std::vector<Light>& after);
/// Makes them. Throws InputError naming `origin` and the light where there is none of that number,
/// or it is of another kind.
void change_lights(const LightChanges& changes, const std::string& origin,
                   std::vector<Light>& lights);

}  // namespace kappamu::render
