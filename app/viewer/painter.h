// Edits of an object's volume by hand: strokes of a brush over the picture, tried while the button
// is held and kept when it is let go, and edits of regions, tried until they are kept; all are
// taken back and done again.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/live/live_scene.h"
#include "render/live/live_volume.h"
#include "render/look_at.h"

namespace kappamu::app {

/// What an edit does.
struct Brush {
  enum class Of { kappa, mu };

  render::Operation operation = render::Operation::multiply;
  Of of = Of::mu;
  double amount = 3.0;  ///< a of render/edit/edit.h: a factor, mm or 1/mm
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< of copy
  double radius_mm = 1.0, depth_mm = 1.0;
  std::string channel;  ///< empty: all

  render::Edit edit(render::Selection where) const;
};

/// What a person asks of the edits, by a button or a line of a script.
enum class Asked { nothing, undo, redo, save, preview, keep, cancel };

class Painter {
 public:
  /// Keeps references to both.
  Painter(const render::Scene& scene, const render::World& world);

  /// The volume of an object, read when first asked for; none where its material is homogeneous.
  render::LiveVolume* volume(std::size_t object);
  /// The first object that has one.
  std::optional<std::size_t> first_volume() const;

  /// Goes on with the stroke, or begins one, to the point (x, y) in [0, 1]² of the picture, from
  /// its top left corner. Whether voxels changed. Beside objects, and on those without a volume,
  /// there is nothing to paint.
  bool stroke_to(const render::LookAt& look, double x, double y, const Brush& brush);
  /// Whether there was a stroke, which is kept.
  bool end_stroke();

  /// Tries an edit of the first object that has a volume, in place of the one on trial.
  void preview(const render::Edit& edit);
  bool on_trial() const { return tried_.has_value(); }
  /// Keeps the edit on trial, or takes it back. Whether there was one.
  bool keep();
  bool cancel();

  bool can_undo() const { return !done_.empty(); }
  bool can_redo() const { return !undone_.empty(); }
  /// Of the last edit of any object. Whether there was one.
  bool undo();
  bool redo();

  /// Of the objects that were painted.
  std::map<std::size_t, render::ObjectMedia> media() const;

  /// Writes each painted object's volume and recipe: into `out`, or a folder of the object's name
  /// there where several were painted. Names of files; warnings are added.
  std::vector<std::string> save(const std::filesystem::path& out,
                                std::vector<std::string>& warnings) const;

 private:
  const render::Scene& scene_;
  const render::World& world_;
  std::map<std::size_t, std::unique_ptr<render::LiveVolume>> volumes_;
  std::vector<std::size_t> done_, undone_;  ///< objects, edit by edit
  void done(std::size_t object);

  std::optional<std::size_t> stroked_, tried_;
  render::Stroke stroke_;
};

}  // namespace kappamu::app
