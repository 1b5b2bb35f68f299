#include "app/viewer/painter.h"

#include <algorithm>

#include "core/error.h"
#include "io/volume/volume_file.h"

namespace kappamu::app {

render::Edit Brush::edit(render::Selection where) const {
  render::Edit edit;
  edit.operation = operation;
  if (operation == render::Operation::copy) {
    edit.offset_mm = offset_mm;
  } else {
    (of == Of::kappa ? edit.kappa : edit.mu) = amount;
  }
  if (operation == render::Operation::blend) edit.share = 0.5;
  if (!channel.empty()) edit.channels = {channel};
  edit.where = std::move(where);
  return edit;
}

Painter::Painter(const render::Scene& scene, const render::World& world)
    : scene_(scene), world_(world) {
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (render::is_editable(scene.objects[i])) editable_.push_back(i);
  }
  if (!editable_.empty()) in_hand_ = editable_.front();
}

render::LiveVolume& Painter::volume(std::size_t object) {
  std::unique_ptr<render::LiveVolume>& volume = volumes_[object];
  if (!volume) {
    volume = std::make_unique<render::LiveVolume>(scene_.objects[object], world_.objects()[object]);
  }
  return *volume;
}

bool Painter::add_to_stroke(const render::LookAt& look, const Eigen::Vector2d& at) {
  const auto hit = world_.first_hit(look.position(), look.direction(at.x(), at.y()), 0.0);
  if (!hit || (stroked_ && *stroked_ != hit->object)) return false;
  if (std::find(editable_.begin(), editable_.end(), hit->object) == editable_.end()) return false;
  volume(hit->object).add_point(*hit, stroke_);
  stroked_ = in_hand_ = hit->object;
  return true;
}

bool Painter::stroke_through(const render::LookAt& look, const std::vector<Eigen::Vector2d>& points,
                             const Brush& brush) {
  require_valid(brush.edit(render::WholeSelection{}));
  bool added = false;
  for (const Eigen::Vector2d& at : points) added = add_to_stroke(look, at) || added;
  if (!added) return false;
  cancel();
  render::LiveVolume& painted = volume(*stroked_);
  render::BrushSelection where;
  where.strokes = painted.in_box(stroke_);
  where.radius_mm = brush.radius_mm;
  where.depth_mm = brush.depth_mm;
  where.stretch = painted.stretch();
  stroke_changes_ = painted.history().try_edit(brush.edit(where)) > 0;
  return stroke_changes_;
}

Painter::Stroked Painter::end_stroke() {
  if (!stroked_) return Stroked::none;
  const bool kept = stroke_changes_;
  if (kept) {
    commit(*stroked_);
  } else {
    volume(*stroked_).history().try_edit(std::nullopt);
  }
  stroked_.reset();
  stroke_ = {};
  stroke_changes_ = false;
  return kept ? Stroked::kept : Stroked::nothing_changed;
}

void Painter::commit(std::size_t object) {
  volumes_.at(object)->history().commit();
  done_.push_back(object);
  undone_.clear();
  changed(object);
}

void Painter::preview(const render::Edit& edit) {
  if (!in_hand_) throw InputError("no object here is of measured material");
  require_valid(edit);
  cancel();
  volume(*in_hand_).history().try_edit(edit);
  tried_ = in_hand_;
}

bool Painter::keep() {
  if (!tried_) return false;
  commit(*tried_);
  tried_.reset();
  return true;
}

bool Painter::cancel() {
  if (!tried_) return false;
  volumes_.at(*tried_)->history().try_edit(std::nullopt);
  tried_.reset();
  return true;
}

bool Painter::undo() {
  cancel();
  if (done_.empty()) return false;
  const std::size_t object = done_.back();
  volumes_.at(object)->history().undo();
  undone_.push_back(object);
  done_.pop_back();
  changed(object);
  return true;
}

bool Painter::redo() {
  cancel();
  if (undone_.empty()) return false;
  const std::size_t object = undone_.back();
  volumes_.at(object)->history().redo();
  done_.push_back(object);
  undone_.pop_back();
  changed(object);
  return true;
}

std::map<std::size_t, render::ObjectMedia> Painter::media() const {
  std::map<std::size_t, render::ObjectMedia> media;
  for (const auto& [object, volume] : volumes_) {
    if (volume) media.emplace(object, volume->media());
  }
  return media;
}

void Painter::open(const std::filesystem::path& out) {
  std::map<std::size_t, EditFolder> folders;
  for (const std::size_t object : editable_) {
    const auto& material = std::get<render::VolumeMaterial>(scene_.objects[object].material);
    folders.emplace(object, EditFolder(editable_.size() == 1 ? out : out / name(object),
                                       io::find_volume(material.volume)));
  }
  for (auto& [object, folder] : folders) {
    if (!folder.has_edits()) continue;
    if (history(object) != nullptr && history(object)->can_undo()) {
      throw InputError(out.string() + ": holds other edits already; choose another folder");
    }
    folder.restore(volume(object).history());
    done_.insert(done_.end(), volume(object).history().recipe().edits.size(), object);
  }
  folders_ = std::move(folders);
  if (keeps_unsaved_) keep_unsaved();
}

const render::EditHistory* Painter::history(std::size_t object) const {
  const auto found = volumes_.find(object);
  return found == volumes_.end() || !found->second ? nullptr : &found->second->history();
}

void Painter::changed(std::size_t object) const {
  if (keeps_unsaved_ && is_open()) folders_.at(object).keep(history(object)->recipe());
}

void Painter::keep_unsaved() {
  keeps_unsaved_ = true;
  for (const std::size_t object : editable_) {
    if (history(object) != nullptr) changed(object);
  }
}

bool Painter::unsaved() const {
  return std::any_of(editable_.begin(), editable_.end(), [&](std::size_t object) {
    const render::EditHistory* edits = history(object);
    if (edits == nullptr) return false;
    return is_open() ? !folders_.at(object).is_saved(edits->recipe()) : edits->can_undo();
  });
}

std::vector<std::filesystem::path> Painter::unsaved_files() const {
  std::vector<std::filesystem::path> files;
  for (const auto& [object, folder] : folders_) {
    if (std::filesystem::exists(folder.unsaved_file())) files.push_back(folder.unsaved_file());
  }
  return files;
}

void Painter::discard() {
  keeps_unsaved_ = false;
  for (const auto& [object, folder] : folders_) folder.discard();
}

std::vector<std::string> Painter::save(std::vector<std::string>& warnings) {
  std::vector<std::string> files;
  for (auto& [object, folder] : folders_) {
    if (history(object) == nullptr || folder.is_saved(history(object)->recipe())) continue;
    const EditedVolume written = folder.save(history(object)->recipe());
    files.insert(files.end(), written.files.begin(), written.files.end());
    warnings.insert(warnings.end(), written.warnings.begin(), written.warnings.end());
  }
  return files;
}

}  // namespace kappamu::app
