// Where the edits of a window are kept. Of each edited object: volume.vdb and recipe.json as saved,
// and unsaved.json, the recipe as it is now, until it is saved or discarded.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/edit/edited_volume.h"
#include "render/edit/history.h"

namespace kappamu::app {

class EditFolder {
 public:
  /// Of one object: `folder` itself, or its sub-folder of the object's name where a scene has
  /// several. `source` is the object's volume. Throws InputError unless it can be saved into.
  EditFolder(std::filesystem::path folder, std::filesystem::path source);

  /// Whether an earlier window left edits.
  bool has_edits() const;
  /// Does to `history` what an earlier window left: the edits it did not save, else those it saved.
  /// Throws InputError when the saved volume is not `history`'s volume with the saved edits.
  void restore(render::EditHistory& history);

  /// Whether `recipe` is what was saved last.
  bool is_saved(const render::Recipe& recipe) const;
  /// Writes unsaved.json, or removes it where `recipe` is what was saved last.
  void keep(const render::Recipe& recipe) const;
  /// Removes unsaved.json.
  void discard() const;
  EditedVolume save(const render::Recipe& recipe);

  std::filesystem::path unsaved_file() const { return folder_ / "unsaved.json"; }

 private:
  std::string text(const render::Recipe& recipe) const;

  std::filesystem::path folder_, source_;
  std::string saved_;  ///< text of the recipe saved last
};

}  // namespace kappamu::app
