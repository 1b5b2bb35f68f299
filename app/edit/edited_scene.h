// A scene's file with an object as edits have left it.
#pragma once

#include <filesystem>
#include <string>

#include "render/scene/edited_object.h"

namespace kappamu::app {

/// Text of a scene's file in `folder`, where volume.vdb lies unless the object is homogeneous: all
/// of `scene`'s file, names in it made relative to `folder`, the material and surface of `object`
/// those of `edited`, and so are the lights. A model that does not answer for the volume is
/// replaced by `embedded`.
std::string edited_scene(const render::Scene& scene, std::size_t object,
                         const render::EditedObject& edited, const std::filesystem::path& folder);

}  // namespace kappamu::app
