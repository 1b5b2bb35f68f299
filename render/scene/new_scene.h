// A first scene to edit, with comments: what `kappamu render --new-scene` writes.
#pragma once

#include <filesystem>
#include <string>

namespace kappamu::render {

/// `material` is a run folder, a fit folder or a .vdb file, whose block becomes the object, or the
/// name of a published material, worn by a sphere. The text is for a scene that lies in `folder`:
/// files are named from there. Throws InputError where `material` is neither.
std::string new_scene(const std::string& material, const std::filesystem::path& folder);

}  // namespace kappamu::render
