#include "app/edit/edit_folder.h"

#include <algorithm>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/volume/volume_file.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* writer = "view";

void replay(const render::Recipe& recipe, render::EditHistory& history) {
  for (const render::Edit& edit : recipe.edits) {
    history.try_edit(edit);
    history.commit();
  }
}

/// As they are on disk, in single precision.
bool equal(const Volume<double>& one, const Volume<double>& other) {
  return std::equal(
      one.values().begin(), one.values().end(), other.values().begin(), other.values().end(),
      [](double a, double b) { return static_cast<float>(a) == static_cast<float>(b); });
}

bool equal(const io::VolumeSet& one, const io::VolumeSet& other) {
  if (!(one.shape() == other.shape()) || one.channels != other.channels) return false;
  for (std::size_t c = 0; c < one.channels.size(); ++c) {
    if (!equal(one.media[c].kappa, other.media[c].kappa)) return false;
    if (!equal(one.media[c].mu, other.media[c].mu)) return false;
  }
  return true;
}

}  // namespace

EditFolder::EditFolder(fs::path folder, fs::path source)
    : folder_(std::move(folder)), source_(std::move(source)), saved_(text({})) {
  // Begun and not committed: leaves no trace.
  const pipeline::OutputFolder probe(folder_, writer, {source_}, {"volume.vdb", "recipe.json"});
}

std::string EditFolder::text(const render::Recipe& recipe) const {
  return render::recipe_json(recipe, pipeline::canonical_path(folder_));
}

bool EditFolder::has_edits() const {
  return fs::exists(folder_ / "recipe.json") || fs::exists(unsaved_file());
}

void EditFolder::restore(render::EditHistory& history) {
  const fs::path recipe = folder_ / "recipe.json";
  if (fs::exists(recipe)) {
    const render::Recipe saved = render::read_recipe(recipe);
    replay(saved, history);
    if (!equal(history.volume(), io::read_volume(folder_ / "volume.vdb"))) {
      throw InputError(recipe.string() + ": these edits were saved for another volume than " +
                       source_.string() + "; choose another folder for edits");
    }
    saved_ = text(saved);
  }
  if (!fs::exists(unsaved_file())) return;
  const render::Recipe unsaved = render::read_recipe(unsaved_file());
  while (history.can_undo()) history.undo();
  replay(unsaved, history);
}

bool EditFolder::is_saved(const render::Recipe& recipe) const {
  return text(recipe) == saved_;
}

void EditFolder::keep(const render::Recipe& recipe) const {
  if (is_saved(recipe)) {
    discard();
    return;
  }
  pipeline::make_output_folder(folder_);
  io::write_text_atomically(unsaved_file(), text(recipe));
}

void EditFolder::discard() const {
  std::error_code ignored;
  fs::remove(unsaved_file(), ignored);
  if (fs::is_empty(folder_, ignored)) fs::remove(folder_, ignored);
}

EditedVolume EditFolder::save(const render::Recipe& recipe) {
  EditedVolume written = write_edited(source_, recipe, "the window's edits", folder_, writer);
  saved_ = text(recipe);
  discard();
  return written;
}

}  // namespace kappamu::app
