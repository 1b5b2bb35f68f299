#include "app/viewer/painter.h"

#include "app/edited_volume.h"

namespace kappamu::app {

Painter::Painter(const render::Scene& scene, const render::World& world)
    : scene_(scene), world_(world) {}

render::LiveVolume* Painter::volume(std::size_t object) {
  if (!std::holds_alternative<render::VolumeMaterial>(scene_.objects[object].material))
    return nullptr;
  std::unique_ptr<render::LiveVolume>& volume = volumes_[object];
  if (!volume) {
    volume = std::make_unique<render::LiveVolume>(scene_.objects[object], world_.objects()[object]);
  }
  return volume.get();
}

std::optional<std::size_t> Painter::first_volume() const {
  for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
    if (std::holds_alternative<render::VolumeMaterial>(scene_.objects[i].material)) return i;
  }
  return std::nullopt;
}

bool Painter::stroke_to(const render::LookAt& look, double x, double y, const Brush& brush) {
  const auto hit = world_.first_hit(look.position(), look.direction(x, y), 0.0);
  if (!hit || (stroked_ && *stroked_ != hit->object)) return false;
  render::LiveVolume* painted = volume(hit->object);
  if (painted == nullptr) return false;
  stroked_ = hit->object;
  painted->add_point(*hit, stroke_);
  render::Edit edit;
  edit.operation = brush.operation;
  (brush.of == Brush::Of::kappa ? edit.kappa : edit.mu) = brush.amount;
  if (brush.operation == render::Operation::blend) edit.share = 0.5;
  if (!brush.channel.empty()) edit.channels = {brush.channel};
  render::BrushSelection where;
  where.strokes = {stroke_};
  where.radius_mm = brush.radius_mm;
  where.depth_mm = brush.depth_mm;
  where.stretch = painted->stretch();
  edit.where = where;
  return painted->history().try_edit(edit) > 0;
}

bool Painter::end_stroke() {
  if (!stroked_) return false;
  volumes_[*stroked_]->history().commit();
  done_.push_back(*stroked_);
  undone_.clear();
  stroked_.reset();
  stroke_ = {};
  return true;
}

bool Painter::undo() {
  if (done_.empty()) return false;
  volumes_[done_.back()]->history().undo();
  undone_.push_back(done_.back());
  done_.pop_back();
  return true;
}

bool Painter::redo() {
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
