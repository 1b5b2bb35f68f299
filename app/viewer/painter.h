// Edits of objects by hand: strokes of a brush over the picture, tried while the button is
// held and kept when it is let go, and edits of regions, tried until they are kept; all are taken
// back and done again, and none is lost (app/edit/edit_folder.h).
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/edit/edit_folder.h"
#include "render/live/live_scene.h"
#include "render/look_at.h"

namespace kappamu::app {

/// What an edit does.
struct Brush {
  /// The coefficient, or the artist's term, that it is of.
  enum class Of { kappa, mu, albedo, mean_free_path };

  render::Operation operation = render::Operation::multiply;
  Of of = Of::mu;
  double amount = 3.0;  ///< a of render/edit/edit.h: a factor, mm or 1/mm
  double share = 0.5;   ///< of blend
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< of copy
  double radius_mm = 1.0, depth_mm = 1.0;
  double hardness = 0.5;  ///< share of the radius with full weight
  std::string channel;    ///< empty: all

  render::Edit edit(render::Selection where) const;
};
inline constexpr Names<Brush::Of, 4> brush_terms{{{"kappa", Brush::Of::kappa},
                                                  {"mu", Brush::Of::mu},
                                                  {"albedo", Brush::Of::albedo},
                                                  {"mean_free_path", Brush::Of::mean_free_path}}};

/// What a person asks of the edits, by a button or a line of a script. `changed`: a group of the
/// panel has edited by itself.
enum class Asked { nothing, undo, redo, save, preview, keep, cancel, changed };

class Painter {
 public:
  /// Keeps references to both.
  Painter(const render::Scene& scene, const render::World& world);

  std::size_t objects() const { return scene_.objects.size(); }
  const std::string& name(std::size_t object) const { return scene_.objects[object].name; }
  /// The object that regions, materials and slices are of: the one painted last, at first the
  /// first.
  std::size_t in_hand() const { return in_hand_; }
  void take(std::size_t object) { in_hand_ = object; }
  /// Made when first asked for, which reads its volume.
  render::EditedObject& edited(std::size_t object);
  /// None: not made yet.
  const render::EditedObject* made(std::size_t object) const;
  /// Of one material all through, as it is now.
  bool is_homogeneous(std::size_t object) const;
  /// η and roughness, as they are now.
  std::array<double, 2> surface(std::size_t object) const;
  /// Directions of the volume's axes in the world: columns x, y, z.
  Eigen::Matrix3d axes(std::size_t object);

  /// Goes on with the stroke, or begins one, through points (x, y) in [0, 1]² of the picture, from
  /// its top left corner. Whether voxels changed. Beside objects there is nothing to paint. Throws
  /// InputError naming a value of `brush` that no recipe may have.
  bool stroke_through(const render::LookAt& look, const std::vector<Eigen::Vector2d>& points,
                      const Brush& brush);
  /// How a stroke ended.
  enum class Stroked { none, nothing_changed, kept };
  Stroked end_stroke();

  /// Throws an image from where the camera is, over the picture's height, in the frame of the
  /// object in hand; image and depths stay.
  void take_view(const render::Camera& camera, render::ProjectionSelection& projection) const;

  /// Tries an edit of the object in hand, in place of the one on trial. Throws InputError as
  /// stroke_through().
  void preview(const render::Edit& edit);
  bool on_trial() const { return tried_.has_value(); }
  /// Keeps the edit on trial, or takes it back. Whether there was one.
  bool keep();
  bool cancel();

  /// Edits done to the object in hand.
  render::EditList list() const;
  /// Edits the list of the object in hand. Whether the object changed.
  bool change_list(const std::function<std::size_t(render::EditHistory&)>& change);

  /// The object's deformations: the scene's own, with the edits.
  std::vector<render::Deformation> deformations(std::size_t object) const;
  /// Edits the object so that it has these: one state.
  void deform(std::size_t object, const std::vector<render::Deformation>& deformations);
  /// The object's deformations made a shape that no body has: it gets those `before`. Where the
  /// last edit made them, that edit is undone and cannot be redone.
  void take_back_shape(std::size_t object, const std::vector<render::Deformation>& before);

  /// The object's fur: the scene's own, with the edits.
  render::Fur fur(std::size_t object) const;
  /// Edits it: one state. Throws InputError naming a value that no recipe may have.
  void change_fur(std::size_t object, const render::FurChange& change);

  /// The scene's lights, as they were last kept.
  const std::vector<render::Light>& lights() const { return lit_[lit_at_]; }
  /// Keeps lights that are not as they were: one state.
  void keep_lights(const std::vector<render::Light>& lights);
  /// Whether lights are others by an undo, a redo or a folder, since the last call.
  bool take_lights() { return std::exchange(lights_are_others_, false); }

  bool can_undo() const { return !done_.empty(); }
  bool can_redo() const { return !undone_.empty(); }
  /// Of the last edit of any object, or of the lights. Whether there was one.
  bool undo();
  bool redo();

  /// Of the objects that were painted.
  std::map<std::size_t, render::ObjectMedia> media() const;

  /// Edits are saved to `out`, or to a folder of the object's name there where the scene has
  /// several objects. What lies there of an earlier window and is not replaced by edits of
  /// this one is done again. Throws InputError as EditFolder, or where both have edits.
  void open(const std::filesystem::path& out);
  bool is_open() const { return !folders_.empty(); }
  /// Whether there are edits, or undone ones, since the last saving.
  bool unsaved() const;
  /// Files that hold what is not saved.
  std::vector<std::filesystem::path> unsaved_files() const;
  /// Writes what is not saved where the next window finds it, after every change from now on.
  void keep_unsaved();
  void discard();
  /// Writes each object with edits since the last saving. Names of the files.
  std::vector<std::string> save();

 private:
  /// Whether the point is on the object under the stroke, or begins one.
  bool add_to_stroke(const render::LookAt& look, const Eigen::Vector2d& at);
  /// The shape that the scene gives an object, which edits by hand begin with.
  struct Shape {
    TriangleMesh mesh;
    std::unique_ptr<RayCaster> rays;
  };

  /// `done_` and `undone_` have this for the lights.
  static constexpr std::size_t of_lights = std::numeric_limits<std::size_t>::max();
  /// Whether it may have something to save: objects that were edited, and the first one where
  /// lights were.
  bool is_saved_with(std::size_t object) const {
    return made(object) != nullptr || (object == 0 && lit_.size() > 1);
  }
  render::Recipe recipe(std::size_t object) const;
  void step_lights(std::size_t to);
  void lights_changed() const;
  /// As edits in the folders have them.
  void restore_lights(const std::filesystem::path& out);
  void commit(std::size_t object);
  void changed(std::size_t object) const;
  void noted(std::size_t object);

  const render::Scene& scene_;
  const render::World& world_;
  std::vector<std::array<double, 2>> surfaces_;  ///< of unedited objects: η, roughness
  std::size_t in_hand_ = 0;
  std::map<std::size_t, Shape> shapes_;  ///< of `edited_`
  std::map<std::size_t, std::unique_ptr<render::EditedObject>> edited_;
  std::map<std::size_t, EditFolder> folders_;
  bool keeps_unsaved_ = false;
  std::vector<std::size_t> done_, undone_;       ///< objects, edit by edit
  std::vector<std::vector<render::Light>> lit_;  ///< states of the lights, the scene's first
  std::size_t lit_at_ = 0;                       ///< of `lit_`
  bool lights_are_others_ = false;

  std::optional<std::size_t> stroked_, tried_;
  bool stroke_changes_ = false;
  render::Stroke stroke_;
};

}  // namespace kappamu::app
