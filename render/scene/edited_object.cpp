#include "render/scene/edited_object.h"

#include "render/embree_caster.h"
#include "render/scene/object_shape.h"

namespace kappamu::render {

EditedObject::EditedObject(const std::filesystem::path& volume, std::size_t most_voxels) {
  io::VolumeSet set = io::read_volume(volume, most_voxels);
  const GridShape& shape = set.shape();
  const double h = shape.voxel_mm;
  object_.name = "block";
  object_.shape = std::string("cube");
  object_.size_mm = Eigen::Vector3d(h * shape.nx, h * shape.ny, h * shape.nz);
  object_.material = VolumeMaterial{volume};
  block_ = make_object_mesh(object_, warnings_);
  at_block_ = make_embree_caster(block_);
  rest_ = mesh_ = &block_;
  rays_ = at_block_.get();
  placing_ = placing_of(std::get<VolumeMaterial>(object_.material), shape,
                        bounding_box(block_).sizes(), volume.string());
  begin(std::move(set));
}

EditedObject::EditedObject(const SceneObject& object, const TriangleMesh& rest,
                           const TriangleMesh& mesh, const RayCaster& rays,
                           std::optional<double> voxel_mm)
    : object_(object), rest_(&rest), mesh_(&mesh), rays_(&rays), voxel_mm_(voxel_mm) {
  if (!object.edits) {
    object_.deform_unedited = object.deform;
  } else if (object.deform != object.deform_unedited) {
    unedited_ = deformed(rest, object.deform_unedited);
    at_unedited_ = make_embree_caster(unedited_);
    mesh_ = &unedited_;
    rays_ = at_unedited_.get();
  }
  begin();
  if (object.edits) do_scenes_edits(mesh, rays);
}

std::unique_ptr<EditedBody> EditedObject::make_body(const TriangleMesh& mesh, const RayCaster& rays,
                                                    const GridShape& shape) const {
  return std::make_unique<EditedBody>(
      mesh, rays, placing_.object_from_volume,
      shape.voxel_mm * Eigen::Vector3d(shape.nx, shape.ny, shape.nz), placing_.wrap);
}

const EditedBody* EditedObject::body_of(const std::vector<Deformation>& deformations) {
  if (deformed_ && deformed_->deformations == deformations) return deformed_->body.get();
  auto shape = std::make_unique<Shape>();
  shape->deformations = deformations;
  shape->mesh = deformed(*rest_, deformations);
  shape->rays = make_embree_caster(shape->mesh);
  shape->body = make_body(shape->mesh, *shape->rays, history_->volume().shape());
  deformed_ = std::move(shape);
  return deformed_->body.get();
}

void EditedObject::require_body() const {
  deformed_body(*rest_, history_->deformations());
}

void EditedObject::begin() {
  const auto* material = std::get_if<HomogeneousMaterial>(&object_.material);
  if (material == nullptr) {
    PlacedVolume placed = placed_volume(object_, *rest_, *mesh_, voxel_mm_, warnings_);
    placing_ = std::move(placed.placing);
    begin(std::move(placed.set));
    return;
  }
  placing_.source = material->source;
  io::VolumeSet voxel = one_voxel(*material);
  if (object_.finish.eta) voxel.eta = object_.finish.eta;
  history_ = std::make_unique<EditHistory>(
      std::move(voxel),
      [this] {
        PlacedVolume placed = placed_volume(object_, *rest_, *mesh_, voxel_mm_, warnings_);
        placing_ = std::move(placed.placing);
        const GridShape& shape = placed.set.shape();
        body_ = make_body(*mesh_, *rays_, shape);
        return EditHistory::Refined{std::move(placed.set), body_.get()};
      },
      this);
}

void EditedObject::begin(io::VolumeSet set) {
  if (object_.finish.eta) set.eta = object_.finish.eta;
  body_ = make_body(*mesh_, *rays_, set.shape());
  history_ = std::make_unique<EditHistory>(std::move(set), body_.get(), at_block_ ? nullptr : this);
}

void EditedObject::do_scenes_edits(const TriangleMesh& mesh, const RayCaster& rays) {
  const Recipe recipe = read_recipe(*object_.edits);
  if (!voxel_mm_) voxel_mm_ = recipe.voxel_mm;
  std::vector<std::string> warnings;
  apply(recipe, object_.edits->string(), *history_, warnings);
  for (const std::string& warning : warnings) {
    warnings_.push_back(object_.edits->string() + ": " + warning);
  }
  mesh_ = &mesh;
  rays_ = &rays;
  object_.deform_unedited = object_.deform;
  deformed_.reset();
  if (history_->eta()) object_.finish.eta = history_->eta();
  if (history_->roughness()) object_.finish.roughness = *history_->roughness();
  if (const std::optional<HomogeneousMaterial> edited = homogeneous()) {
    object_.material = *edited;
    begin();
  } else {
    begin(io::VolumeSet(history_->volume()));
  }
}

Recipe EditedObject::recipe() const {
  Recipe recipe = history_->recipe();
  recipe.voxel_mm = voxel_mm_;
  recipe.lights = lights_;
  return recipe;
}

std::optional<HomogeneousMaterial> EditedObject::homogeneous() const {
  if (!history_->homogeneous()) return std::nullopt;
  HomogeneousMaterial material = std::get<HomogeneousMaterial>(object_.material);
  for (std::size_t c = 0; c < 3; ++c) {
    const Medium& medium = history_->volume().media[c];
    material.kappa_mm[static_cast<Eigen::Index>(c)] = medium.kappa[0];
    material.mu_per_mm[static_cast<Eigen::Index>(c)] = medium.mu[0];
  }
  return material;
}

double EditedObject::roughness() const {
  return history_->roughness().value_or(object_.finish.roughness);
}

const ObjectMedia& EditedObject::media() const {
  if (!media_ || media_->first != history_->revision()) {
    ObjectMedia media =
        history_->homogeneous()
            ? media_of(history_->volume(), std::get<HomogeneousMaterial>(object_.material).source)
            : media_of(history_->volume(), placing_);
    media.roughness = roughness();
    media_.emplace(history_->revision(), std::move(media));
  }
  return media_->second;
}

}  // namespace kappamu::render
