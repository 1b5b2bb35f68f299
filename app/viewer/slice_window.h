// Slices through an object's volume, with a probe: κ, μ, their standard deviations, and whatever
// else its file has.
#pragma once

#include "app/viewer/panel_picture.h"
#include "app/viewer/view_state.h"
#include "io/volume/volume_set.h"

namespace kappamu::app {

class SliceWindow {
 public:
  /// Between ImGui's NewFrame and Render, with a context current.
  void draw(const io::VolumeSet& set, Slice& slice);

 private:
  PanelPicture picture_;
};

}  // namespace kappamu::app
