#include "app/viewer/painter.h"

#include "app/edited_volume.h"
#include "core/error.h"

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
    : scene_(scene), world_(world) {}

render::LiveVolume* Painter::volume(std::size_t object) {
  if (!render::is_editable(scene_.objects[object])) return nullptr;
  std::unique_ptr<render::LiveVolume>& volume = volumes_[object];
  if (!volume) {
    volume = std::make_unique<render::LiveVolume>(scene_.objects[object], world_.objects()[object]);
  }
  return volume.get();
}

std::optional<std::size_t> Painter::first_volume() const {
  for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
    if (render::is_editable(scene_.objects[i])) return i;
  }
  return std::nullopt;
}

bool Painter::stroke_to(const render::LookAt& look, double x, double y, const Brush& brush) {
  const auto hit = world_.first_hit(look.position(), look.direction(x, y), 0.0);
  if (!hit || (stroked_ && *stroked_ != hit->object)) return false;
  render::LiveVolume* painted = volume(hit->object);
  if (painted == nullptr) return false;
  stroked_ = hit->object;
  cancel();
  painted->add_point(*hit, stroke_);
  render::BrushSelection where;
  where.strokes = {stroke_};
  where.radius_mm = brush.radius_mm;
  where.depth_mm = brush.depth_mm;
  where.stretch = painted->stretch();
  return painted->history().try_edit(brush.edit(where)) > 0;
}

bool Painter::end_stroke() {
  if (!stroked_) return false;
  done(*stroked_);
  stroked_.reset();
  stroke_ = {};
  return true;
}

void Painter::done(std::size_t object) {
  volumes_[object]->history().commit();
  done_.push_back(object);
  undone_.clear();
}

void Painter::preview(const render::Edit& edit) {
  const std::optional<std::size_t> object = first_volume();
  if (!object) throw InputError("no object here is of measured material");
  volume(*object)->history().try_edit(edit);
  tried_ = object;
}

bool Painter::keep() {
  if (!tried_) return false;
  done(*tried_);
  tried_.reset();
  return true;
}

bool Painter::cancel() {
  if (!tried_) return false;
  volumes_[*tried_]->history().try_edit(std::nullopt);
  tried_.reset();
  return true;
}

bool Painter::undo() {
  cancel();
  if (done_.empty()) return false;
  volumes_[done_.back()]->history().undo();
  undone_.push_back(done_.back());
  done_.pop_back();
  return true;
}

bool Painter::redo() {
  cancel();
  if (undone_.empty()) return false;
  volumes_[undone_.back()]->history().redo();
  done_.push_back(undone_.back());
  undone_.pop_back();
  return true;
}

std::map<std::size_t, render::ObjectMedia> Painter::media() const {
  std::map<std::size_t, render::ObjectMedia> media;
  for (const auto& [object, volume] : volumes_) {
    if (volume) media.emplace(object, volume->media());
  }
  return media;
}

std::vector<std::string> Painter::save(const std::filesystem::path& out,
                                       std::vector<std::string>& warnings) const {
  std::vector<std::size_t> painted;
  for (const auto& [object, volume] : volumes_) {
    if (volume && volume->history().can_undo()) painted.push_back(object);
  }
  std::vector<std::string> files;
  for (const std::size_t object : painted) {
    const render::LiveVolume& volume = *volumes_.at(object);
    const EditedVolume written =
        write_edited(volume.source(), volume.history().recipe(), "the window's edits",
                     painted.size() == 1 ? out : out / scene_.objects[object].name, "view");
    files.insert(files.end(), written.files.begin(), written.files.end());
    warnings.insert(warnings.end(), written.warnings.begin(), written.warnings.end());
  }
  return files;
}

}  // namespace kappamu::app
