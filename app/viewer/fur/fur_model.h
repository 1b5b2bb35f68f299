// The fur of a scene that is looked at: what sliders and the brush have set, and what a card draws
// of it. Tiles are made on a thread of their own, coarsely at first; the last one is shown until
// then.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "render/fur/live_fur.h"
#include "render/live/live_answer.h"
#include "render/look_at.h"
#include "render/scene/world.h"

namespace kappamu::app {

/// What dragging over fur does.
struct FurBrush {
  enum class Of { comb, length, density, colour };

  Of of = Of::comb;
  double radius_mm = 2.0;
  double amount = 0.5;  ///< towards which length, density go, 0 to 1
  Eigen::Array3d colour{0.9, 0.4, 0.2};
};

class FurModel {
 public:
  /// Keeps references to both. Throws InputError as render::coat_of().
  FurModel(const render::Scene& scene, const render::World& world);
  ~FurModel();

  bool any() const { return !coats_.empty(); }
  std::size_t coats() const { return coats_.size(); }
  const render::World& world() const { return world_; }

  FurBrush brush;

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
  };
  const Shown& shown(std::size_t coat) const;
  const std::string& name(std::size_t coat) const;
  bool making(std::size_t coat) const;  ///< a tile is on its way
  bool making() const;                  ///< of any coat

  /// Other fur from now on.
  void set(std::size_t coat, const render::Fur& fur);
  /// Draws the brush from one point of the picture to another, both in [0, 1]² from its top left
  /// corner. Whether fur lies there.
  bool stroke(const render::LookAt& look, const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  void set_lights(const std::vector<render::Light>& lights);
  /// The mesh has moved.
  void moved();

  /// Does what the calls above asked for. Whether the picture changes. Throws InputError.
  bool update();
  /// Of the light that skin sends out, what there is under its fur.
  void shade(render::LiveAnswer& answer) const;
  /// Waits for the finest tiles.
  void finish();

 private:
  struct Coat;
  void begin_tile(Coat& coat, int rays) const;

  const render::World& world_;
  std::vector<std::unique_ptr<Coat>> coats_;
  std::vector<render::Light> lights_;
};

}  // namespace kappamu::app
