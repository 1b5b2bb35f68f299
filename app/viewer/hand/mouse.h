// What mouse and keys do in the picture: Blender's and ParaView's habits, and handles of lights.
#pragma once

#include <optional>

#include "app/viewer/view_state.h"
#include "app/viewer/window.h"

namespace kappamu::app {

class Mouse {
 public:
  /// Between ImGui's NewFrame and Render, where no panel has the mouse.
  void follow(ViewState& state);
  /// Whether a light is being dragged, so that the brush and the orbit leave the mouse alone.
  bool holds_light() const { return light_.has_value(); }

 private:
  std::optional<std::size_t> light_;  ///< whose handle is dragged
  bool behind_ = false;               ///< the handle lies behind the object
};

/// What a key asks of the edits.
Asked asked_by(const KeyEvent& event);
/// Keys of the view, the lights and the panel. `home` is the scene's own view.
void follow_view_key(const KeyEvent& event, const render::Camera& home, ViewState& state);

}  // namespace kappamu::app
