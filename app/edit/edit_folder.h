// Where the edits of a window are kept. Of each edited object: its files as saved, and
// unsaved.json, the recipe as it is now, until it is saved or discarded.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/edit/edited_volume.h"

namespace kappamu::app {

class EditFolder {
 public:
  /// Of one object: `folder` itself, or its sub-folder of the object's name where a scene has
  /// several. Keeps the source's reference. Throws InputError unless it can be saved into.
  EditFolder(std::filesystem::path folder, EditSource source);

  /// Whether an earlier window left edits.
  bool has_edits() const;
  /// Edge of voxels that those are for.
  std::optional<double> voxel_mm() const;
  /// Does to the object what an earlier window left: the edits it did not save, else those it
  /// saved. Throws InputError when the saved volume is not the object's with the saved edits.
  void restore(render::EditedObject& edited);

  /// Whether `recipe` is what was saved last.
  bool is_saved(const render::Recipe& recipe) const;
  /// Writes unsaved.json, or removes it where `recipe` is what was saved last.
  void keep(const render::Recipe& recipe) const;
  /// Removes unsaved.json.
  void discard() const;
  /// Names of the files.
  std::vector<std::string> save(const render::EditedObject& edited);

  std::filesystem::path unsaved_file() const { return folder_ / "unsaved.json"; }

 private:
  std::string text(const render::Recipe& recipe) const;

  std::filesystem::path folder_;
  EditSource source_;
  std::string saved_;  ///< text of the recipe saved last
};

}  // namespace kappamu::app
