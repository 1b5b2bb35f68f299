// An edited object or volume and its recipe on disk, as `kappamu edit` and the window of
// `kappamu view` leave them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/scene/edited_object.h"

namespace kappamu::app {

/// What is edited: an object of a scene, or a volume by itself.
struct EditSource {
  const render::Scene* scene = nullptr;  ///< none: a volume by itself
  std::size_t object = 0;                ///< of the scene
  std::filesystem::path volume;          ///< where there is no scene

  /// Scene or volume, for messages.
  std::string name() const { return (scene ? scene->file : volume).string(); }
  /// Everything that the edited object is made of.
  std::vector<std::filesystem::path> files() const;
};

/// Writes to `out`, whole or not at all: recipe.json; volume.vdb, unless a homogeneous object is
/// one still; of a scene scene.json as well, the scene with the object as it is now. `command` owns
/// the files there; `inputs` are read beside those of source and recipe. Returns their names.
std::vector<std::string> write_edited(const render::EditedObject& edited, const EditSource& source,
                                      const std::filesystem::path& out, const std::string& command,
                                      const std::vector<std::filesystem::path>& inputs = {});

/// Names of the files that write_edited() may write.
std::vector<std::string> edited_files(const EditSource& source);

}  // namespace kappamu::app
