// What a person or a script sets in the window.
#pragma once

#include <string>
#include <vector>

#include "app/viewer/painter.h"
#include "render/live/light_handle.h"
#include "render/look_at.h"
#include "render/scene/scene.h"

namespace kappamu::app {

/// What dragging with the left button does.
enum class Tool { orbit, brush, shape };

/// A slice through a volume.
struct Slice {
  bool shown = false;
  std::size_t volume = 0;  ///< of io::named_volumes()
  int axis = 2;            ///< that it lies across
  int index = 0;           ///< voxel along the axis
};

/// What a photograph is shown of.
struct Photograph {
  bool shown = false;
  int number = 0;  ///< from 0
};

/// Where an edit is done that is no stroke: of each kind, what a person has set. Depths and boxes
/// are of the object's frame.
struct Region {
  enum class Kind { stroke, all, depth, box, projection, texture };

  Kind kind = Kind::stroke;
  render::DepthSelection depth{.frame = render::Frame::object};
  render::BoxSelection box{.frame = render::Frame::object};
  render::ProjectionSelection projection;
  render::TextureSelection texture;

  render::Selection selection() const;  ///< not of strokes
};

struct ViewState {
  std::string model;  ///< that shall answer
  std::vector<render::Light> lights;
  std::size_t lamp = 0;                              ///< the light in hand
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< that lights turn about [mm]
  render::Camera camera;
  double exposure = 1.0;
  bool panel = true;
  Tool tool = Tool::orbit;
  Brush brush;
  Region region;
  std::string edits;  ///< folder that edits are saved in
  Slice slice;
  Photograph photograph;
  int channel = 0;  ///< shown: 0 all, else one, grey

  bool has_handle() const { return lamp < lights.size() && render::has_angles(lights[lamp]); }
  void turn_light(const render::LightAngles& angles) {
    lights[lamp] = render::turned_to(lights[lamp], centre, angles);
  }
  /// Rays through a picture of this width over its height.
  render::LookAt look(double aspect) const {
    return {camera.position_mm, camera.target_mm, camera.up, camera.fov_deg, aspect};
  }
  /// The camera about its target: to its right and upwards [degrees], short of the poles.
  void orbit(double right_deg, double up_deg);
  /// The camera's distance to its target, times `factor`.
  void zoom(double factor);
};

}  // namespace kappamu::app
