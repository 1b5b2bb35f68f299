// What a person or a script does with the shapes of objects: deformations by sliders and by a
// brush, which are edits once they rest. A change after which a surface would cross itself is taken
// back.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/painter.h"
#include "render/live/live_scene.h"
#include "render/look_at.h"

namespace kappamu::app {

/// What dragging over an object does to its shape.
struct ShapeBrush {
  render::DeformKind kind = render::DeformKind::pull;  ///< or dent, whose amount is the way down
  double radius_mm = 1.0;
  double edge = 1.0;
};

class Shaping {
 public:
  /// Keeps references; the world is the one that is shown.
  Shaping(const render::World& world, Painter& painter);

  ShapeBrush brush;
  bool renewal = false;  ///< links are made anew for every shape

  const render::World& world() const { return world_; }
  std::vector<render::Deformation> of(std::size_t object) const;
  /// Longest edge of an object's box at rest [mm].
  double size(std::size_t object) const;
  /// The deformation that a slider begins with: along the longest edge, without an amount.
  render::Deformation begun(std::size_t object, render::DeformKind kind) const;

  /// Other deformations of an object. While `moving`, others follow; the shape is looked at, and
  /// becomes an edit, with the first that does not move.
  void set(std::size_t object, std::vector<render::Deformation> deformations, bool moving);

  /// A stroke of the brush from one point of the picture to another, both in [0, 1]² from its top
  /// left corner. press() is false beside all objects.
  bool press(const render::LookAt& look, const Eigen::Vector2d& at);
  void drag(const render::LookAt& look, const Eigen::Vector2d& at);
  void release();
  bool pressed() const { return stroke_.has_value(); }

  /// Whether shapes changed since the last call.
  bool take_change() { return std::exchange(changed_, false); }
  render::ShapeQuestion question() const;
  /// Takes back the last shape where the answer refused it; other edits stay.
  void take(const render::LiveAnswer& answer);
  /// Why the last change was taken back; empty: it was not.
  const std::string& note() const { return note_; }

 private:
  struct Stroke {
    std::size_t object = 0;
    Eigen::Vector3d from = Eigen::Vector3d::Zero();  ///< in the world [mm]
  };
  /// Of an object whose shape moves.
  struct Moving {
    std::size_t object = 0;
    std::vector<render::Deformation> deformations;
  };

  /// The last edit of a shape, which an answer may refuse.
  struct Made {
    std::size_t object = 0;
    std::vector<render::Deformation> deformations, before;
  };

  const render::World& world_;
  Painter& painter_;
  std::optional<Moving> moving_;
  std::optional<Made> made_;
  std::optional<Stroke> stroke_;
  bool changed_ = false;
  std::string note_;
};

}  // namespace kappamu::app
