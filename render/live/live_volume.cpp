#include "render/live/live_volume.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/volume/volume_file.h"

namespace kappamu::render {

bool is_editable(const SceneObject& object) {
  const auto* material = std::get_if<VolumeMaterial>(&object.material);
  return material != nullptr && material->placement != VolumeMaterial::Placement::shell;
}

namespace {

using Eigen::Vector3d;

/// Where the way from `from` to `to` passes from one box to the next of a space filled with them:
/// shares of the way, 0 and 1 among them.
std::vector<double> crossings(const Vector3d& from, const Vector3d& to, const Vector3d& box) {
  std::vector<double> cuts{0.0, 1.0};
  for (int axis = 0; axis < 3; ++axis) {
    const double a = from[axis] / box[axis], b = to[axis] / box[axis];
    for (double plane = std::floor(std::min(a, b)) + 1.0; plane < std::max(a, b); plane += 1.0) {
      cuts.push_back((plane - a) / (b - a));
    }
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

/// A stroke in the box that holds `middle`, moved to the first box.
void fold(const Vector3d& middle, const Vector3d& box, Wrap wrap, Stroke& stroke) {
  for (int axis = 0; axis < 3; ++axis) {
    const double tile = std::floor(middle[axis] / box[axis]);
    const bool mirrored = wrap == Wrap::mirror && std::fmod(tile, 2.0) != 0.0;
    for (std::size_t i = 0; i < stroke.points_mm.size(); ++i) {
      double& at = stroke.points_mm[i][axis];
      at -= tile * box[axis];
      if (!mirrored) continue;
      at = box[axis] - at;
      stroke.inward[i][axis] *= -1.0;
    }
  }
}

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
    : object_(object),
      made_(made),
      source_(source),
      history_(io::read_volume(source)),
      wrap_(wrap_of(std::get<VolumeMaterial>(object.material).placement)) {
  const Eigen::Affine3d object_from_volume =
      render::object_from_volume(std::get<VolumeMaterial>(object.material),
                                 history_.volume().shape(), bounding_box(made.mesh).sizes());
  stretch_ = object_from_volume.linear().colwise().norm();
  volume_from_object_ = object_from_volume.inverse();
}

ObjectMedia LiveVolume::media() const {
  return media_of(history_.volume(), object_, bounding_box(made_.rest).sizes(), source_.string());
}

void LiveVolume::add_point(const WorldHit& hit, Stroke& stroke) const {
  const Eigen::Vector3d in_object = made_.world_from_object.inverse() * hit.position;
  const Eigen::Vector3d inward = made_.world_from_object.rotation.transpose() * -hit.normal;
  stroke.points_mm.push_back(volume_from_object_ * in_object);
  // Turned only: depths are of the object.
  stroke.inward.push_back(
      (stretch_.asDiagonal() * (volume_from_object_.linear() * inward)).normalized());
}

std::vector<Stroke> LiveVolume::in_box(const Stroke& stroke) const {
  if (wrap_ == Wrap::clamp) return {stroke};
  const GridShape& shape = history_.volume().shape();
  const Vector3d box = shape.voxel_mm * Vector3d(shape.nx, shape.ny, shape.nz);
  std::vector<Stroke> pieces;
  for (std::size_t i = 0; i < stroke.points_mm.size(); ++i) {
    const std::size_t next = std::min(i + 1, stroke.points_mm.size() - 1);
    const Vector3d &from = stroke.points_mm[i], &to = stroke.points_mm[next];
    if (next == i && i > 0) break;
    const std::vector<double> cuts = crossings(from, to, box);
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const auto at = [&](double t) -> Vector3d { return from + t * (to - from); };
      const Vector3d middle = at(0.5 * (cuts[c] + cuts[c + 1]));
      Stroke piece;
      for (const double t : {cuts[c], cuts[c + 1]}) {
        const Vector3d inward = (1.0 - t) * stroke.inward[i] + t * stroke.inward[next];
        piece.points_mm.push_back(at(t));
        piece.inward.push_back(inward.norm() > 1e-6 ? inward.normalized() : stroke.inward[i]);
      }
      fold(middle, box, wrap_, piece);
      pieces.push_back(std::move(piece));
    }
  }
  return pieces;
}

Eigen::Matrix3d LiveVolume::axes() const {
  const Eigen::Matrix3d object_from_volume = volume_from_object_.linear().inverse();
  return made_.world_from_object.rotation * object_from_volume.colwise().normalized();
}

}  // namespace kappamu::render
