// The pressed left button over the picture, where it holds the brush or drags the surface.
#pragma once

#include <vector>

#include "app/viewer/editing.h"
#include "app/viewer/hand/mouse.h"
#include "app/viewer/shaping.h"
#include "app/viewer/view_state.h"
#include "app/viewer/window.h"

namespace kappamu::app {

class Strokes {
 public:
  /// Keeps references.
  Strokes(Editing& editing, Shaping& shaping) : editing_(editing), shaping_(shaping) {}

  /// Through every position that the pointer had. Between ImGui's NewFrame and Render, after the
  /// mouse has taken what it holds.
  void follow(const std::vector<PointerEvent>& events, const Mouse& mouse, const ViewState& state);

 private:
  Editing& editing_;
  Shaping& shaping_;
  bool stroking_ = false;  ///< the pressed button leads the brush
};

}  // namespace kappamu::app
