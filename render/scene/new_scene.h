// A first scene to edit, with comments: what `kappamu render --new-scene` writes.
#pragma once

#include <filesystem>
#include <string>

namespace kappamu::render {

/// `what` is a run folder, a fit folder or a .vdb file, whose block becomes the object; the name of
/// a published material, worn by a sphere; or a mesh file, which wears marble. The text is for a
/// scene that lies in `folder`: files are named from there. Throws InputError where `what` is none
/// of these.
std::string new_scene(const std::string& what, const std::filesystem::path& folder);

}  // namespace kappamu::render
