// Slices through an object's volume, with a probe: κ, μ, their standard deviations, and whatever
// else its file has.
#pragma once

#include "app/viewer/panel/panel_picture.h"
#include "app/viewer/view_state.h"
#include "io/volume/volume_set.h"

namespace kappamu::app {

class SliceWindow {
 public:
  /// Between ImGui's NewFrame and Render, with a context current.
  /// `axes` are the volume's in the world, as Painter has them, `camera` the view: the slice
  /// stands upright in it.
  void draw(const io::VolumeSet& set, const Eigen::Matrix3d& axes, const render::Camera& camera,
            float scale, Slice& slice);

 private:
  PanelPicture picture_;
};

}  // namespace kappamu::app
