// A scene's object of measured material while its volume is edited: where on it a brush paints, and
// the media that result.
#pragma once

#include "render/edit/history.h"
#include "render/scene/object_media.h"
#include "render/scene/world.h"

namespace kappamu::render {

/// Whether its material is a volume that lies in it as a solid.
bool is_editable(const SceneObject& object);

class LiveVolume {
 public:
  /// Reads the object's volume. `made` is the object in the world, which outlives this. Throws
  /// InputError where the object is not editable.
  LiveVolume(const SceneObject& object, const WorldObject& made);

  EditHistory& history() { return history_; }
  const EditHistory& history() const { return history_; }
  const std::filesystem::path& source() const { return source_; }

  /// Of history().volume() as it is now.
  ObjectMedia media() const;

  /// Adds where a ray met the object to a stroke, in the volume's frame continued beyond its box.
  void add_point(const WorldHit& hit, Stroke& stroke) const;
  /// The stroke where the volume's own box lies: itself, or pieces of it in the box where the
  /// volume repeats or mirrors itself.
  std::vector<Stroke> in_box(const Stroke& stroke) const;
  /// Directions of the volume's axes in the world: columns x, y, z.
  Eigen::Matrix3d axes() const;
  /// As BrushSelection has it.
  Eigen::Vector3d stretch() const { return stretch_; }

 private:
  LiveVolume(const SceneObject& object, const WorldObject& made,
             const std::filesystem::path& source);

  SceneObject object_;
  const WorldObject& made_;
  std::filesystem::path source_;
  EditHistory history_;
  Eigen::Affine3d volume_from_object_;
  Wrap wrap_;
  Eigen::Vector3d
      stretch_;  ///< millimetres of the object per millimetre of the volume, along its axes
};

}  // namespace kappamu::render
