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
  std::vector<std::string> ignored;  // the window that made them showed them
  apply(recipe, "the window's edits", history, ignored);
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

EditFolder::EditFolder(fs::path folder, EditSource source)
    : folder_(std::move(folder)), source_(std::move(source)), saved_(text({})) {
  // Begun and not committed: leaves no trace.
  const pipeline::OutputFolder probe(folder_, writer, source_.files(), edited_files(source_));
}

std::string EditFolder::text(const render::Recipe& recipe) const {
  return render::recipe_json(recipe, pipeline::canonical_path(folder_));
}

bool EditFolder::has_edits() const {
  return fs::exists(folder_ / "recipe.json") || fs::exists(unsaved_file());
}

std::optional<double> EditFolder::voxel_mm() const {
  for (const fs::path& file : {unsaved_file(), folder_ / "recipe.json"}) {
    if (fs::exists(file)) return render::read_recipe(file).voxel_mm;
  }
  return std::nullopt;
}

void EditFolder::restore(render::EditedObject& edited) {
  render::EditHistory& history = edited.history();
  const fs::path file = folder_ / "recipe.json", volume = folder_ / "volume.vdb";
  if (fs::exists(file)) {
    const render::Recipe recipe = render::read_recipe(file);
    replay(recipe, history);
    if (fs::exists(volume) == history.homogeneous() ||
        (fs::exists(volume) && !equal(history.volume(), io::read_volume(volume)))) {
      throw InputError(file.string() + ": these edits were saved for another volume than that of " +
                       source_.name() + "; choose another folder for edits");
    }
    edited.set_lights(recipe.lights);
    saved_ = text(edited.recipe());
  }
  if (!fs::exists(unsaved_file())) return;
  const render::Recipe unsaved = render::read_recipe(unsaved_file());
  while (history.can_undo()) history.undo();
  replay(unsaved, history);
  edited.set_lights(unsaved.lights);
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

std::vector<std::string> EditFolder::save(const render::EditedObject& edited) {
  std::vector<std::string> written = write_edited(edited, source_, folder_, writer);
  saved_ = text(edited.recipe());
  discard();
  return written;
}

}  // namespace kappamu::app
