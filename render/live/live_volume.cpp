#include "render/live/live_volume.h"

#include "core/error.h"
#include "io/volume/volume_file.h"

namespace kappamu::render {

bool is_editable(const SceneObject& object) {
  const auto* material = std::get_if<VolumeMaterial>(&object.material);
  return material != nullptr && material->placement != VolumeMaterial::Placement::shell;
}

namespace {

std::filesystem::path volume_of(const SceneObject& object) {
  if (is_editable(object)) {
    return io::find_volume(std::get<VolumeMaterial>(object.material).volume);
  }
  throw InputError("object '" + object.name +
                   "' is of one material all through, or wrapped in a shell; only a volume "
                   "placed as a solid can be edited");
}

}  // namespace

LiveVolume::LiveVolume(const SceneObject& object, const WorldObject& made)
    : LiveVolume(object, made, volume_of(object)) {}

LiveVolume::LiveVolume(const SceneObject& object, const WorldObject& made,
                       const std::filesystem::path& source)
    : object_(object), made_(made), source_(source), history_(io::read_volume(source)) {
  const Eigen::Affine3d object_from_volume =
      render::object_from_volume(std::get<VolumeMaterial>(object.material),
                                 history_.volume().shape(), bounding_box(made.mesh).sizes());
  stretch_ = object_from_volume.linear().colwise().norm();
  volume_from_object_ = object_from_volume.inverse();
}

ObjectMedia LiveVolume::media() const {
  return media_of(history_.volume(), object_, bounding_box(made_.mesh).sizes(), source_.string());
}

void LiveVolume::add_point(const WorldHit& hit, Stroke& stroke) const {
  const Eigen::Vector3d in_object = made_.world_from_object.inverse() * hit.position;
  const Eigen::Vector3d inward = made_.world_from_object.rotation.transpose() * -hit.normal;
  stroke.points_mm.push_back(volume_from_object_ * in_object);
  // Turned only: depths are of the object.
  stroke.inward.push_back(
      (stretch_.asDiagonal() * (volume_from_object_.linear() * inward)).normalized());
}

}  // namespace kappamu::render
