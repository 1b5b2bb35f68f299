#include "render/edit/edited_body.h"

#include <cmath>

#include "core/error.h"
#include "forward/polygrid/closest_point.h"

namespace kappamu::render {

namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

/// The volume's box the number `tile` along each axis from its own, as that moves there.
Affine3d moved(const Eigen::Vector3i& tile, const Vector3d& box, Wrap wrap) {
  Vector3d scale = Vector3d::Ones(), shift;
  for (int axis = 0; axis < 3; ++axis) {
    const bool mirrored = wrap == Wrap::mirror && tile[axis] % 2 != 0;
    scale[axis] = mirrored ? -1.0 : 1.0;
    shift[axis] = (tile[axis] + (mirrored ? 1 : 0)) * box[axis];
  }
  Affine3d map = Affine3d::Identity();
  map.translate(shift).scale(scale);
  return map;
}

}  // namespace

EditedBody::EditedBody(const TriangleMesh& mesh, const RayCaster& rays,
                       const Affine3d& object_from_volume, const Vector3d& volume_mm, Wrap wrap)
    : mesh_(mesh),
      rays_(rays),
      object_from_volume_(object_from_volume),
      volume_mm_(volume_mm),
      wrap_(wrap),
      skin_(1e-6 * bounding_box(mesh).diagonal().norm()) {}

std::vector<Affine3d> EditedBody::images() const {
  constexpr double most_images = 1e5;
  if (wrap_ == Wrap::clamp) return {object_from_volume_};
  const Eigen::AlignedBox3d seen = bounding_box(mesh_).transformed(object_from_volume_.inverse());
  const Eigen::Array3d first = (seen.min().array() / volume_mm_.array()).floor(),
                       last = (seen.max().array() / volume_mm_.array()).floor();
  if ((last - first + 1.0).prod() > most_images) {
    throw InputError(
        "the volume lies in the object more than 100,000 times; edit it in the volume's frame");
  }
  std::vector<Affine3d> images;
  for (double z = first.z(); z <= last.z(); ++z) {
    for (double y = first.y(); y <= last.y(); ++y) {
      for (double x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector3i tile = Vector3d(x, y, z).cast<int>();
        images.push_back(object_from_volume_ * moved(tile, volume_mm_, wrap_));
      }
    }
  }
  return images;
}

EditedBody::~EditedBody() = default;

std::optional<Vector3d> EditedBody::in_volume(const Vector3d& in_object) const {
  Vector3d place = object_from_volume_.inverse() * in_object;
  if (wrap_ != Wrap::clamp) {
    const Eigen::Vector3i tile = (place.array() / volume_mm_.array()).floor().cast<int>().matrix();
    place = moved(tile, volume_mm_, wrap_).inverse() * place;
  }
  if ((place.array() < 0.0).any() || (place.array() >= volume_mm_.array()).any()) {
    return std::nullopt;
  }
  return place;
}

EditedBody::Below EditedBody::below(const Vector3d& point) const {
  std::call_once(asked_, [&] { closest_ = std::make_unique<forward::ClosestPoint>(mesh_); });
  const forward::ClosestPoint::Found found = closest_->from(point);
  const Vector3d& normal = closest_->normal(found.triangle);
  const bool outside = (point - found.point).dot(normal) > 0.0;
  return {outside ? -found.distance : found.distance, found.point, normal, found.triangle,
          found.weights};
}

Eigen::Vector2d EditedBody::texture_at(const Below& place) const {
  const CornerTexture& texture = mesh_.texture[static_cast<std::size_t>(place.triangle)];
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    at += place.weights[static_cast<Eigen::Index>(k)] * texture[k].cast<double>();
  }
  return at;
}

bool EditedBody::sees(const Vector3d& eye, const Below& place) const {
  const Vector3d way = eye - place.surface;
  if (way.dot(place.normal) <= 0.0) return false;
  const double distance = way.norm();
  return !rays_.any_hit(place.surface + skin_ * place.normal, way / distance, skin_, distance);
}

}  // namespace kappamu::render
