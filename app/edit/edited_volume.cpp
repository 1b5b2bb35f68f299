#include "app/edit/edited_volume.h"

#include <variant>

#include "io/atomic_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/verify.h"
#include "render/edit/history.h"

namespace kappamu::app {

EditedVolume write_edited(const std::filesystem::path& volume, const render::Recipe& recipe,
                          const std::string& origin, const std::filesystem::path& out,
                          const std::string& command,
                          const std::vector<std::filesystem::path>& recipe_file,
                          std::size_t most_voxels) {
  EditedVolume written{io::find_volume(volume), {}, {}};
  pipeline::require_as_written(written.source);
  const io::VolumeSet set = io::read_volume(written.source, most_voxels);
  const io::VolumeSet result = render::edited(set, recipe, origin, written.warnings);
  std::vector<std::filesystem::path> inputs{volume, written.source};
  inputs.insert(inputs.end(), recipe_file.begin(), recipe_file.end());
  for (const render::Edit& edit : recipe.edits) {
    if (const auto* texture = std::get_if<render::TextureSelection>(&edit.where))
      inputs.push_back(texture->image);
  }
  pipeline::OutputFolder folder(out, command, inputs, {"volume.vdb", "recipe.json"});
  io::write_vdb(folder.partial() / "volume.vdb", result);
  io::write_text_atomically(folder.partial() / "recipe.json",
                            render::recipe_json(recipe, folder.path()));
  folder.commit();
  written.files = {(out / "volume.vdb").string(), (out / "recipe.json").string()};
  return written;
}

}  // namespace kappamu::app
