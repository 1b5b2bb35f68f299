// Fur drawn over the objects of a canvas: both into a linear picture of their own, which is then
// tone-mapped into the canvas's. Shells are drawn from the farthest to the nearest one of each
// object; where two furs or two folds lie before each other, the nearer one may be drawn first.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/viewer/drawing/canvas.h"
#include "app/viewer/fur/fur_model.h"

namespace kappamu::app {

class FurCanvas {
 public:
  /// With a context current. Throws InputError where it refuses the shaders.
  FurCanvas();

  /// Between the canvas's begin() and end(), in place of its draw().
  void draw(Canvas& canvas, const Seen& seen, const Viewport& at, const FurModel& model);

  double apart_px = 1.0;  ///< shells that would lie nearer to each other are merged
  double shells() const { return shells_; }  ///< drawn last, of the first coat

 private:
  struct Coat {
    unsigned array = 0, geometry = 0, light = 0;
    std::array<unsigned, 3> volumes{};
    int volume_version = 0, geometry_version = 0, light_version = 0, corners = 0;
    std::string reflectance;   ///< of the norms below
    std::vector<float> norms;  ///< of HairReflectance, which take tenths of a second
  };
  void upload(const FurModel::Shown& shown, Coat& coat);
  void draw_shells(const Seen& seen, const Viewport& at, const FurModel::Shown& shown, Coat& coat);
  void resize(int width, int height);

  unsigned shell_ = 0, whole_ = 0;  ///< programs
  unsigned frame_ = 0, colour_ = 0, depth_ = 0, nothing_ = 0;
  int width_ = 0, height_ = 0;
  double shells_ = 0.0;
  std::vector<Coat> coats_;
};

}  // namespace kappamu::app
