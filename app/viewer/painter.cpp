#include "app/viewer/painter.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/error.h"
#include "render/embree_caster.h"

namespace kappamu::app {

render::Edit Brush::edit(render::Selection where) const {
  render::Edit edit;
  edit.operation = operation;
  if (operation == render::Operation::copy) {
    edit.offset_mm = offset_mm;
  } else {
    constexpr std::array amounts{&render::Edit::kappa, &render::Edit::mu, &render::Edit::albedo,
                                 &render::Edit::mean_free_path_mm};
    edit.*amounts[static_cast<std::size_t>(of)] = {amount};
  }
  if (operation == render::Operation::blend) edit.share = share;
  if (!channel.empty()) edit.channels = {channel};
  edit.where = std::move(where);
  return edit;
}

Painter::Painter(const render::Scene& scene, const render::World& world)
    : scene_(scene), world_(world), lit_{scene.lights} {
  for (const render::WorldObject& object : world.objects()) {
    surfaces_.push_back({object.boundary.eta, object.roughness});
  }
}

render::EditedObject& Painter::edited(std::size_t object) {
  std::unique_ptr<render::EditedObject>& edited = edited_[object];
  if (!edited) {
    const render::WorldObject& made = world_.objects()[object];
    const auto folder = folders_.find(object);
    Shape& shape = shapes_[object];
    shape.mesh = render::deformed(made.rest, scene_.objects[object].deform);
    shape.rays = render::make_embree_caster(shape.mesh);
    edited = std::make_unique<render::EditedObject>(
        scene_.objects[object], made.rest, shape.mesh, *shape.rays,
        folder == folders_.end() ? std::nullopt : folder->second.voxel_mm());
  }
  return *edited;
}

bool Painter::is_homogeneous(std::size_t object) const {
  if (made(object) != nullptr) return made(object)->history().homogeneous();
  const render::SceneObject& of = scene_.objects[object];
  return std::holds_alternative<render::HomogeneousMaterial>(of.material) && !of.edits;
}

std::array<double, 2> Painter::surface(std::size_t object) const {
  const render::EditedObject* edited = made(object);
  if (edited == nullptr) return surfaces_[object];
  return {edited->history().volume().eta.value_or(surfaces_[object][0]), edited->roughness()};
}

Eigen::Matrix3d Painter::axes(std::size_t object) {
  const Eigen::Matrix3d in_object = edited(object).placing().object_from_volume.linear();
  return world_.objects()[object].world_from_object.rotation * in_object.colwise().normalized();
}

bool Painter::add_to_stroke(const render::LookAt& look, const Eigen::Vector2d& at) {
  const auto hit = world_.first_hit(look.position(), look.direction(at.x(), at.y()), 0.0);
  if (!hit || (stroked_ && *stroked_ != hit->object)) return false;
  const Rigid& world_from_object = world_.objects()[hit->object].world_from_object;
  stroke_.points_mm.push_back(world_from_object.inverse() * hit->position);
  stroke_.inward.push_back((world_from_object.rotation.transpose() * -hit->normal).normalized());
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
  render::BrushSelection where;
  where.frame = render::Frame::object;
  where.strokes = {stroke_};
  where.radius_mm = brush.radius_mm;
  where.depth_mm = brush.depth_mm;
  where.hardness = brush.hardness;
  stroke_changes_ = false;  // where the next line throws
  stroke_changes_ = edited(*stroked_).history().try_edit(brush.edit(where)) > 0;
  return stroke_changes_;
}

void Painter::take_view(const render::Camera& camera,
                        render::ProjectionSelection& projection) const {
  const Rigid object_from_world = world_.objects()[in_hand_].world_from_object.inverse();
  projection.position_mm = object_from_world * camera.position_mm;
  projection.target_mm = object_from_world * camera.target_mm;
  projection.up = (object_from_world.rotation * camera.up).normalized();
  projection.fov_deg = camera.fov_deg;
}

Painter::Stroked Painter::end_stroke() {
  if (!stroked_) return Stroked::none;
  const bool kept = stroke_changes_;
  if (kept) {
    commit(*stroked_);
  } else {
    edited(*stroked_).history().try_edit(std::nullopt);
  }
  stroked_.reset();
  stroke_ = {};
  stroke_changes_ = false;
  return kept ? Stroked::kept : Stroked::nothing_changed;
}

void Painter::commit(std::size_t object) {
  edited(object).history().commit();
  noted(object);
}

void Painter::noted(std::size_t object) {
  done_.push_back(object);
  undone_.clear();
  changed(object);
}

void Painter::preview(const render::Edit& edit) {
  require_valid(edit);
  cancel();
  edited(in_hand_).history().try_edit(edit);
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
  edited(*tried_).history().try_edit(std::nullopt);
  tried_.reset();
  return true;
}

render::EditList Painter::list() const {
  return made(in_hand_) == nullptr ? render::EditList{} : made(in_hand_)->history().list();
}

bool Painter::change_list(const std::function<std::size_t(render::EditHistory&)>& change) {
  cancel();
  const std::size_t voxels = change(edited(in_hand_).history());
  noted(in_hand_);
  return voxels > 0;
}

std::vector<render::Deformation> Painter::deformations(std::size_t object) const {
  return made(object) == nullptr ? scene_.objects[object].deform
                                 : made(object)->history().deformations();
}

void Painter::deform(std::size_t object, const std::vector<render::Deformation>& deformations) {
  cancel();
  render::EditHistory& history = edited(object).history();
  history.set_list(
      render::with_deformations(history.list(), scene_.objects[object].deform, deformations));
  in_hand_ = object;
  noted(object);
}

void Painter::take_back_shape(std::size_t object, const std::vector<render::Deformation>& before) {
  if (!done_.empty() && done_.back() == object && undo()) {
    if (deformations(object) == before) return undone_.pop_back();
    redo();
  }
  deform(object, before);
}

render::Fur Painter::fur(std::size_t object) const {
  render::Fur fur = *scene_.objects[object].fur;
  if (made(object) != nullptr) made(object)->history().change(fur);
  return fur;
}

void Painter::change_fur(std::size_t object, const render::FurChange& change) {
  if (change.empty()) return;
  render::Edit edit;
  edit.operation = render::Operation::fur;
  edit.fur = change;
  require_valid(edit);
  cancel();
  edited(object).history().try_edit(edit);
  in_hand_ = object;
  commit(object);
}

void Painter::keep_lights(const std::vector<render::Light>& lights) {
  if (light_changes(this->lights(), lights).empty()) return;
  lit_.resize(++lit_at_);
  lit_.push_back(lights);
  done_.push_back(of_lights);
  undone_.clear();
  lights_changed();
}

void Painter::step_lights(std::size_t to) {
  lit_at_ = to;
  lights_are_others_ = true;
  lights_changed();
}

bool Painter::undo() {
  cancel();
  if (done_.empty()) return false;
  const std::size_t object = done_.back();
  undone_.push_back(object);
  done_.pop_back();
  if (object == of_lights) {
    step_lights(lit_at_ - 1);
    return true;
  }
  edited(object).history().undo();
  changed(object);
  return true;
}

bool Painter::redo() {
  cancel();
  if (undone_.empty()) return false;
  const std::size_t object = undone_.back();
  done_.push_back(object);
  undone_.pop_back();
  if (object == of_lights) {
    step_lights(lit_at_ + 1);
    return true;
  }
  edited(object).history().redo();
  changed(object);
  return true;
}

std::map<std::size_t, render::ObjectMedia> Painter::media() const {
  std::map<std::size_t, render::ObjectMedia> media;
  for (const auto& [object, edited] : edited_) {
    if (edited) media.emplace(object, edited->media());
  }
  return media;
}

void Painter::open(const std::filesystem::path& out) {
  std::map<std::size_t, EditFolder> folders;
  for (std::size_t object = 0; object < objects(); ++object) {
    folders.emplace(object, EditFolder(objects() == 1 ? out : out / name(object),
                                       EditSource{&scene_, object, {}}));
  }
  std::swap(folders, folders_);
  try {
    for (auto& [object, folder] : folders_) {
      if (!folder.has_edits()) continue;
      if (made(object) != nullptr && made(object)->history().can_undo()) {
        throw InputError(out.string() + ": holds other edits already; choose another folder");
      }
      edited_.erase(object);  // its voxels are those of the folder
      folder.restore(edited(object));
      done_.insert(done_.end(), edited(object).history().list().size(), object);
    }
    restore_lights(out);
  } catch (...) {
    std::swap(folders, folders_);
    throw;
  }
  if (keeps_unsaved_) keep_unsaved();
}

void Painter::restore_lights(const std::filesystem::path& out) {
  for (const auto& [object, folder] : folders_) {
    if (!folder.has_edits()) continue;
    const render::LightChanges changes = made(object)->recipe().lights;
    if (changes.empty()) continue;
    if (lit_at_ > 0) {
      throw InputError(out.string() + ": holds other lights already; choose another folder");
    }
    std::vector<render::Light> lights = scene_.lights;
    change_lights(changes, out.string(), lights);
    keep_lights(lights);
    std::rotate(done_.begin(), done_.end() - 1, done_.end());  // edits are undone before them
    lights_are_others_ = true;
    return;
  }
}

const render::EditedObject* Painter::made(std::size_t object) const {
  const auto found = edited_.find(object);
  return found == edited_.end() ? nullptr : found->second.get();
}

render::Recipe Painter::recipe(std::size_t object) const {
  render::Recipe recipe;
  if (made(object) != nullptr) recipe = made(object)->recipe();
  recipe.lights = light_changes(scene_.lights, lights());
  return recipe;
}

void Painter::changed(std::size_t object) const {
  if (keeps_unsaved_ && is_open()) folders_.at(object).keep(recipe(object));
}

void Painter::lights_changed() const {
  for (std::size_t object = 0; object < objects(); ++object) {
    if (is_saved_with(object)) changed(object);
  }
}

void Painter::keep_unsaved() {
  keeps_unsaved_ = true;
  lights_changed();
}

bool Painter::unsaved() const {
  for (std::size_t object = 0; object < objects(); ++object) {
    if (!is_saved_with(object)) continue;
    const bool edits = made(object) != nullptr && made(object)->history().can_undo();
    const bool unsaved = is_open() ? !folders_.at(object).is_saved(recipe(object))
                                   : edits || !recipe(object).lights.empty();
    if (unsaved) return true;
  }
  return false;
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

std::vector<std::string> Painter::save() {
  std::vector<std::string> files;
  for (auto& [object, folder] : folders_) {
    if (!is_saved_with(object) || folder.is_saved(recipe(object))) continue;
    edited(object).set_lights(recipe(object).lights);
    const std::vector<std::string> written = folder.save(edited(object));
    files.insert(files.end(), written.begin(), written.end());
  }
  return files;
}

}  // namespace kappamu::app
