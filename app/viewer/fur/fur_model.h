// The fur of a scene that is looked at: as edits have left it, with what a slider or the brush does
// to it just now, and what a card draws of it. Tiles are made on a thread of their own, coarsely at
// first; the last one is shown until then.
#pragma once

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/fur/live_fur.h"
#include "render/live/live_answer.h"
#include "render/look_at.h"
#include "render/scene/world.h"

namespace kappamu::app {

class FurModel {
 public:
  /// Keeps a reference to the world. Throws InputError as render::CoatPainter.
  FurModel(const render::Scene& scene, const render::World& world);
  ~FurModel();

  bool any() const { return !coats_.empty(); }
  std::size_t coats() const { return coats_.size(); }
  const render::World& world() const { return world_; }

  render::FurStroke brush;  ///< what dragging over fur draws; without points

  struct Shown {
    std::size_t object = 0;
    render::Fur fur;
    std::shared_ptr<const render::FurTile> tile;  ///< none yet
    render::FurVolume volume;
    render::FurCorners corners;
    /// Rise where volume, corners' geometry and light are others.
    int volume_version = 0, geometry_version = 0, light_version = 0;
    double tile_s = 0.0, place_ms = 0.0, light_ms = 0.0;  ///< what the last of each took
    std::size_t patches = 0;
    double stretch = 1.0;
    std::vector<double> skin_shares;  ///< per vertex, of its light
    std::string fault;                ///< why fur is not where the shape is
  };
  const Shown& shown(std::size_t coat) const;
  const std::string& name(std::size_t coat) const;
  bool making(std::size_t coat) const;  ///< a tile is on its way
  bool making() const;                  ///< of any coat

  /// Other fur from now on. Throws InputError where it cannot lie on the object.
  void set(std::size_t coat, const render::Fur& fur);
  /// Draws the brush from one point of the picture to another, both in [0, 1]² from its top left
  /// corner. Goes on with the last stroke where that ended. Whether fur lies there.
  bool stroke(const render::LookAt& look, const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  /// The strokes since the last call, as changes of objects' fur.
  std::map<std::size_t, render::FurChange> end_stroke();
  void set_lights(const std::vector<render::Light>& lights);
  /// The mesh has moved.
  void moved();

  /// Does what the calls above asked for. Whether the picture changes. Throws InputError.
  bool update();
  /// Of the light that skin sends out, what there is under its fur.
  void shade(render::LiveAnswer& answer) const;
  /// Waits for the finest tiles.
  void finish();
  /// As edits have left it, `fur_of` an object; where that cannot lie there, it stays.
  void follow(const std::function<render::Fur(std::size_t)>& fur_of);

 private:
  struct Coat;
  /// Where the brush is, on an object's undeformed skin.
  struct At {
    std::size_t object = 0;
    Eigen::Vector3d point_mm;
  };
  std::optional<At> at(const render::LookAt& look, const Eigen::Vector2d& place) const;
  void begin_tile(Coat& coat, int rays) const;

  const render::World& world_;
  std::vector<std::unique_ptr<Coat>> coats_;
  std::vector<render::Light> lights_;
};

}  // namespace kappamu::app
