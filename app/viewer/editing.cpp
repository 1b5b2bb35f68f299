#include "app/viewer/editing.h"

#include "core/error.h"

namespace kappamu::app {

Painter Editing::opened(const render::Scene& scene, const render::World& world,
                        const ViewerOptions& options) {
  Painter painter(scene, world);
  if (options.edits) painter.open(*options.edits);
  return painter;
}

Editing::Editing(const render::Scene& scene, const render::World& world,
                 const ViewerOptions& options, std::function<void()> changed)
    : options_(options), changed_(std::move(changed)), painter_(opened(scene, world, options)) {
  if (!painter_.is_open()) return;
  if (!options.script) painter_.keep_unsaved();
  if (painter_.unsaved()) note_ = "edits that were not saved are back; undo takes them away";
}

template <class Action>
bool Editing::attempt(const Action& action) {
  try {
    action();
    return true;
  } catch (const InputError& error) {
    if (options_.script) throw InputError(options_.script->string() + ": " + error.what());
    note_ = error.what();
    return false;
  }
}

void Editing::stroke_through(const render::LookAt& look, const std::vector<Eigen::Vector2d>& points,
                             const Brush& brush) {
  attempt([&] {
    if (painter_.stroke_through(look, points, brush)) changed_();
  });
}

Painter::Stroked Editing::end_stroke() {
  const Painter::Stroked stroked = painter_.end_stroke();
  if (stroked == Painter::Stroked::nothing_changed) note_ = "this stroke changes no voxel";
  if (stroked == Painter::Stroked::kept) note_.clear();
  return stroked;
}

void Editing::preview(const render::Edit& edit) {
  attempt([&] {
    painter_.preview(edit);
    note_.clear();
    changed_();
  });
}

void Editing::change_fur(std::size_t object, const render::FurChange& change) {
  attempt([&] {
    painter_.change_fur(object, change);
    note_.clear();
  });
  changed_();
}

void Editing::obey_panel(Asked asked, const ViewState& state) {
  if (asked == Asked::preview || asked == Asked::keep) {
    preview(state.brush.edit(state.region.selection()));
  }
  obey(asked, state.edits);
}

void Editing::obey(Asked asked, const std::string& folder) {
  if ((asked == Asked::undo && painter_.undo()) || (asked == Asked::redo && painter_.redo())) {
    changed_();
  }
  if (asked == Asked::save) save(folder);
  if (asked == Asked::keep) painter_.keep();
  if (asked == Asked::changed) changed_();
  if (asked == Asked::cancel && painter_.cancel()) changed_();
}

bool Editing::save(const std::string& folder) {
  return attempt([&] {
    if (folder.empty()) throw InputError("name a folder for edits (--edits OUT)");
    if (!painter_.is_open() || options_.edits != folder) {
      painter_.open(folder);
      options_.edits = folder;
    }
    const std::vector<std::string> files = painter_.save();
    saved_.insert(saved_.end(), files.begin(), files.end());
    note_ = "saved in " + folder;
  });
}

bool Editing::close(Closing closing, const std::string& folder) {
  if (closing == Closing::discard) painter_.discard();
  return closing == Closing::discard || (closing == Closing::save && save(folder));
}

void Editing::interrupted() {
  for (const std::filesystem::path& file : painter_.unsaved_files()) {
    warnings_.push_back("edits that were not saved are kept in " + file.string() +
                        "; the same command continues from them");
  }
}

}  // namespace kappamu::app
