// The materials of a scene's file (docs/scene.md).
#pragma once

#include <filesystem>

#include "io/json_node.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// File names are relative to `folder`. Throws InputError naming file, field and fix.
Material read_material(const io::JsonNode& node, const std::filesystem::path& folder);

/// Shape, size, place and material, which objects and the parts inside them have in common.
SceneObject read_solid(const io::JsonNode& node, const std::filesystem::path& folder);

}  // namespace kappamu::render
