// OpenGL 3.3: a world's corners with their light, drawn into a picture of its own, which goes to
// the window and to files.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/image.h"
#include "render/live/lit_corners.h"
#include "render/scene/scene.h"

namespace kappamu::app {

/// Part of a picture, from its bottom left corner [px].
struct Viewport {
  int x = 0, y = 0, width = 0, height = 0;
};

class Canvas {
 public:
  /// With a context current. Throws InputError where it refuses the shaders.
  explicit Canvas(const std::vector<float>& geometry);

  /// Of as many corners as before, elsewhere.
  void set_geometry(const std::vector<float>& geometry);
  void set_light(const std::vector<float>& light);
  /// Leaves the picture bound, so that a panel can be drawn over it. Without an exposure there is
  /// no light yet, and the shape alone is shaded. `channel` as ViewState has it.
  void draw(const render::Camera& camera, std::optional<double> exposure, int channel,
            double near_mm, double far_mm, int width, int height, const Viewport& at);
  void show(int window_width, int window_height) const;
  Image<std::uint8_t> picture() const;

 private:
  void resize(int width, int height);

  unsigned program_ = 0, array_ = 0, geometry_ = 0, light_ = 0;
  unsigned frame_ = 0, colour_ = 0;                             ///< the picture
  unsigned fine_frame_ = 0, fine_colour_ = 0, fine_depth_ = 0;  ///< several samples a pixel
  int corners_ = 0, width_ = 0, height_ = 0;
};

}  // namespace kappamu::app
