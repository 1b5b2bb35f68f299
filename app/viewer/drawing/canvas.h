// OpenGL 3.3: a world's corners with their light, or a traced picture, drawn into a picture of its
// own, which goes to the window and to files.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/image.h"
#include "render/light/environment.h"
#include "render/live/lit_corners.h"
#include "render/scene/scene.h"

namespace kappamu::app {

/// Part of a picture, from its bottom left corner [px].
struct Viewport {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Viewport&) const = default;
};

/// What is drawn.
struct Seen {
  render::Camera camera;
  std::optional<double> exposure;  ///< none: there is no light yet, and the shape alone is shaded
  int channel = 0;                 ///< as ViewState has it
  double near_mm = 0.1, far_mm = 1.0;
  bool traced = false;  ///< the traced picture, which is of this camera
  bool linear = false;  ///< radiance, before exposure and tone curve
};

/// Throws InputError where OpenGL refuses a shader. Fragment shaders have shaders::tone and sky.
/// `defined`: lines before both.
unsigned linked_program(const char* vertex, const char* fragment, const std::string& defined = "");
/// Attributes of the bound vertex array, from `first` on, of so many floats each, interleaved in
/// the bound buffer.
void set_attributes(unsigned first, const std::vector<int>& sizes);
/// Contents of the bound buffer, for OpenGL's `usage`.
void upload_floats(const std::vector<float>& values, unsigned usage);
Eigen::Matrix4f clip_from_world(const render::Camera& camera, double near_mm, double far_mm,
                                double aspect);

/// Several samples a pixel, or one, which takes less time.
enum class Edges { smooth, plain };

class Canvas {
 public:
  /// With a context current. Throws InputError where it refuses the shaders.
  explicit Canvas(const render::LitCorners::Geometry& geometry);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  /// The light of its corners is set next.
  void set_geometry(const render::LitCorners::Geometry& geometry);
  void set_light(const render::LitCorners& corners, const render::LiveAnswer& answer);
  /// Behind the objects and in their reflections; none: dark.
  void set_sky(const std::optional<render::Environment>& sky);
  void turn_sky(double degrees);
  /// R, G, B of radiance, the top row first.
  void set_traced(const Image<float>& radiance);

  /// Empties a picture of this size.
  void begin(int width, int height, Edges edges);
  /// Into what is bound: its own picture, or another canvas'.
  void draw(const Seen& seen, const Viewport& at);
  void end();
  /// Binds a copy of the picture, which a panel can be drawn over; the picture stays. Both calls
  /// below are of the copy.
  void draw_over();
  void show(int window_width, int window_height) const;
  void finish() const;
  Image<std::uint8_t> picture() const;

 private:
  void resize(int width, int height);
  void copy(unsigned from, unsigned to) const;
  void set_sources(const std::vector<Eigen::Vector4d>& sources);
  unsigned surface_program(bool lit);
  void use(unsigned program, const Seen& seen) const;

  unsigned whole_ = 0;  ///< program
  /// By the number of sources, -1 without light, and whether there is a sky.
  std::map<std::pair<int, bool>, unsigned> surfaces_drawn_;
  unsigned array_ = 0, geometry_ = 0, triangles_ = 0, light_ = 0, nothing_ = 0;
  unsigned objects_ = 0, sky_ = 0, traced_ = 0;                 ///< textures
  unsigned frame_ = 0, colour_ = 0, depth_ = 0;                 ///< the picture
  unsigned fine_frame_ = 0, fine_colour_ = 0, fine_depth_ = 0;  ///< several samples a pixel
  unsigned over_frame_ = 0, over_colour_ = 0;                   ///< with what is drawn over it
  Edges edges_ = Edges::smooth;                                 ///< of the last begin()
  int corners_ = 0, width_ = 0, height_ = 0;
  std::vector<Eigen::Vector4f> sources_;
  std::vector<float> surfaces_;  ///< that `objects_` is of: η and roughness of each
  bool has_sky_ = false, sky_visible_ = false;
  float sky_turn_ = 0.0F;
};

}  // namespace kappamu::app
