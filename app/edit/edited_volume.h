// An edited volume and its recipe on disk, as `kappamu edit` and the window of `kappamu view` leave
// them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/volume/volume_file.h"
#include "render/edit/edit.h"

namespace kappamu::app {

struct EditedVolume {
  std::filesystem::path source;  ///< the volume as it was before
  std::vector<std::string> files, warnings;
};

/// `recipe` on `volume` (a .vdb file, a run folder, a folder with volume.json), written whole to
/// volume.vdb and recipe.json of `out`, or not at all. `command` owns them there; `origin` names
/// the recipe in messages, `recipe_file` is its own, if any.
EditedVolume write_edited(const std::filesystem::path& volume, const render::Recipe& recipe,
                          const std::string& origin, const std::filesystem::path& out,
                          const std::string& command,
                          const std::vector<std::filesystem::path>& recipe_file = {},
                          std::size_t most_voxels = io::default_most_voxels);

}  // namespace kappamu::app
