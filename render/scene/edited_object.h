// A scene's object while its material is edited, or a volume by itself: what is edited, what the
// edits make of it, and its media.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "io/volume/volume_file.h"
#include "render/edit/history.h"
#include "render/scene/object_media.h"
#include "render/scene/scene.h"

namespace kappamu::render {

class EditedObject : public EditedShapes {
 public:
  /// A volume by itself (io::find_volume): the block that it fills, as the first scene of a run has
  /// it, whose own frame has its origin at the block's centre.
  explicit EditedObject(const std::filesystem::path& volume,
                        std::size_t most_voxels = io::default_most_voxels);
  /// `rest` and `mesh`, the object before its deformations and as it is, in its own frame, and
  /// `rays` against `mesh` outlive this. `voxel_mm` as in placed_volume(). Edits that the scene
  /// states of the object are done, and are not in the list. A homogeneous object becomes a volume
  /// at the first edit of a part of it. Throws InputError as placed_volume() and read_recipe().
  EditedObject(const SceneObject& object, const TriangleMesh& rest, const TriangleMesh& mesh,
               const RayCaster& rays, std::optional<double> voxel_mm = std::nullopt);
  EditedObject(const EditedObject&) = delete;
  EditedObject& operator=(const EditedObject&) = delete;

  EditHistory& history() { return *history_; }
  const EditHistory& history() const { return *history_; }
  /// Of the material's making, and of the scene's own edits.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// The list, with the edge of voxels that it is for and the lights.
  Recipe recipe() const;
  /// Of the object's scene.
  void set_lights(LightChanges lights) { lights_ = std::move(lights); }
  /// Of a homogeneous object that is one still.
  std::optional<HomogeneousMaterial> homogeneous() const;
  double roughness() const;
  /// As the object is now; the same ones until it changes.
  const ObjectMedia& media() const;
  /// Throws InputError as deformed_body() where the edits leave a shape that is no body.
  void require_body() const;
  /// Where the volume lies in the object.
  const Placing& placing() const { return placing_; }

 private:
  /// Of a shape that edits have deformed.
  struct Shape {
    std::vector<Deformation> deformations;
    TriangleMesh mesh;
    std::unique_ptr<RayCaster> rays;
    std::unique_ptr<EditedBody> body;
  };
  bool has_fur() const override { return object_.fur.has_value(); }
  const std::vector<Deformation>& unedited() const override { return object_.deform_unedited; }
  const EditedBody* body_of(const std::vector<Deformation>& deformations) override;
  std::unique_ptr<EditedBody> make_body(const TriangleMesh& mesh, const RayCaster& rays,
                                        const GridShape& shape) const;
  void begin();
  void begin(io::VolumeSet set);
  void do_scenes_edits(const TriangleMesh& mesh, const RayCaster& rays);

  SceneObject object_;
  TriangleMesh block_;                   ///< of a volume by itself
  std::unique_ptr<RayCaster> at_block_;  ///< rays against it
  const TriangleMesh *rest_ = nullptr, *mesh_ = nullptr;
  const RayCaster* rays_ = nullptr;
  std::optional<double> voxel_mm_;
  LightChanges lights_;
  std::vector<std::string> warnings_;
  Placing placing_;
  TriangleMesh unedited_;  ///< where the scene's own edits deform the object
  std::unique_ptr<RayCaster> at_unedited_;
  std::unique_ptr<EditedBody> body_;  ///< none: homogeneous so far
  std::unique_ptr<Shape> deformed_;   ///< that was asked for last
  std::unique_ptr<EditHistory> history_;
  mutable std::optional<std::pair<std::size_t, ObjectMedia>> media_;  ///< with their revision
};

}  // namespace kappamu::render
