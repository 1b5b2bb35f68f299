#include "app/edit/edited_volume.h"

#include <variant>

#include "app/edit/edited_scene.h"
#include "io/atomic_file.h"
#include "io/volume/volume_file.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace fs = std::filesystem;

std::vector<fs::path> EditSource::files() const {
  if (scene) return render::files_of(*scene);
  return {volume, io::find_volume(volume)};
}

std::vector<std::string> edited_files(const EditSource& source) {
  std::vector<std::string> names{"volume.vdb", "recipe.json"};
  if (source.scene) names.push_back("scene.json");
  return names;
}

std::vector<std::string> write_edited(const render::EditedObject& edited, const EditSource& source,
                                      const fs::path& out, const std::string& command,
                                      const std::vector<fs::path>& inputs) {
  const render::Recipe recipe = edited.recipe();
  std::vector<fs::path> read = source.files();
  for (const std::vector<fs::path>& more : {inputs, render::files_of(recipe)}) {
    read.insert(read.end(), more.begin(), more.end());
  }
  pipeline::OutputFolder folder(out, command, read, edited_files(source));
  std::vector<std::string> written;
  if (!edited.homogeneous()) {
    io::VolumeSet set = edited.history().volume();
    set.metadata["edits"] = std::to_string(recipe.edits.size());
    io::write_vdb(folder.partial() / "volume.vdb", set);
    written.push_back((out / "volume.vdb").string());
  }
  io::write_text_atomically(folder.partial() / "recipe.json",
                            render::recipe_json(recipe, folder.path()));
  written.push_back((out / "recipe.json").string());
  if (source.scene) {
    io::write_text_atomically(folder.partial() / "scene.json",
                              edited_scene(*source.scene, source.object, edited, folder.path()));
    written.push_back((out / "scene.json").string());
  }
  folder.commit();
  return written;
}

}  // namespace kappamu::app
