// A brush over the picture: strokes become edits of the volume under them, tried while the button
// is held, kept when it is let go, taken back and done again.
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

struct Brush {
  enum class Of { kappa, mu };

  render::Operation operation = render::Operation::multiply;  ///< not copy
  Of of = Of::mu;
  double amount = 3.0;  ///< a of render/edit/edit.h: a factor, mm or 1/mm
  double radius_mm = 1.0, depth_mm = 1.0;
  std::string channel;  ///< empty: all
};

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
  std::optional<std::size_t> stroked_;
  render::Stroke stroke_;
};

}  // namespace kappamu::app
