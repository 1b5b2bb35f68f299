// What a person or a script sets in the window.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/viewer/painter.h"
#include "render/live/light_handle.h"
#include "render/look_at.h"
#include "render/scene/scene.h"

namespace kappamu::app {

/// What dragging with the left button does.
enum class Tool { orbit, brush, shape, fur };

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
  enum class Kind { stroke, all, depth, box, projection, texture, coordinates };

  Kind kind = Kind::stroke;
  render::DepthSelection depth{.frame = render::Frame::object};
  render::BoxSelection box{.frame = render::Frame::object};
  render::ProjectionSelection projection;
  render::TextureSelection texture;
  render::CoordinatesSelection coordinates;

  render::Selection selection() const;  ///< not of strokes
};

/// Where the picture lies in the window, beside the panel and above the line of state [screen
/// coordinates from the top left corner].
struct PictureArea {
  float x = 0.0F, y = 0.0F, width = 1.0F, height = 1.0F;
  bool holds(double window_x, double window_y) const {
    const Eigen::Vector2d at = in_picture(window_x, window_y);
    return at.minCoeff() >= 0.0 && at.maxCoeff() <= 1.0;
  }
  double aspect() const { return static_cast<double>(width) / static_cast<double>(height); }
  /// A point of the window in [0, 1]² of the picture, from its top left corner.
  Eigen::Vector2d in_picture(double window_x, double window_y) const {
    return {(window_x - static_cast<double>(x)) / static_cast<double>(width),
            (window_y - static_cast<double>(y)) / static_cast<double>(height)};
  }
};

/// The state shown left of the one in hand: as the scene's file has it, or as it was when asked.
enum class Compared { nothing, unedited, kept };

/// Of the docked panel and of the line of state [px at scale 1].
constexpr float panel_width = 320.0F, status_height = 26.0F;

/// Views along the world's axes: from +z, +x and +y.
enum class AxisView { front, right, top };

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

  PictureArea area;        ///< of the state in hand
  float scale = 1.0F;      ///< of text and marks, the screen's
  double radius_mm = 1.0;  ///< of all objects, about `centre`
  bool docked = false;     ///< the panel lies beside the picture, else over it
  bool keys_shown = false, marks_shown = true;
  bool traced = true;           ///< the picture is traced at rest
  bool playing = false;         ///< the light in hand turns round
  bool lights_changed = false;  ///< since the last question
  Compared compared = Compared::nothing;
  std::optional<Compared> asked_to_compare;

  /// The scene's own light and camera, and all its objects' box.
  static ViewState of(const render::Scene& scene, const render::World& world);
  /// Where the picture lies in a window of this size: all of it, or its right half. What of a film
  /// is seen stays seen where the picture is halved.
  void lay_out(int width, int height, double film_aspect);
  bool has_handle() const { return lamp < lights.size() && render::has_angles(lights[lamp]); }
  void set_light(render::Light light);
  void turn_light(const render::LightAngles& angles) {
    set_light(render::turned_to(lights[lamp], centre, angles));
  }
  void drag_light(const Eigen::Vector3d& direction) {
    set_light(render::turned_towards(lights[lamp], centre, direction));
  }
  /// The light in hand after so long of turning round by itself [s].
  void turn_on(double seconds);
  /// Handles lie on a sphere about `centre` that fits the picture [mm].
  double handle_radius() const;
  Eigen::Vector3d handle_of(std::size_t light) const {
    return centre + handle_radius() * render::towards(lights[light], centre);
  }
  /// Rays through a picture of this width over its height.
  render::LookAt look(double aspect) const {
    return {camera.position_mm, camera.target_mm, camera.up, camera.fov_deg, aspect};
  }
  /// The picture that the window's part for it shows, as it would be traced; `density`: pixels per
  /// unit of screen coordinates.
  render::PictureView view(float density, int samples) const;
  /// The camera about its target: to its right and upwards [degrees], short of the poles.
  void orbit(double right_deg, double up_deg);
  /// The camera's distance to its target, times `factor`.
  void zoom(double factor);
  /// Camera and target to the right and upwards, by shares of the picture's height.
  void pan(double right, double up);
  /// All objects fill the picture, seen from where they are seen now.
  void frame();
  /// `other_side`: from −z, −x or −y.
  void look_along(AxisView view, bool other_side);

 private:
  bool halved_ = false;  ///< at the last lay_out()
};

}  // namespace kappamu::app
