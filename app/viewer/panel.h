// The numbers and handles over the picture, and what the mouse does.
#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "app/viewer/view_state.h"
#include "render/live/live_scene.h"

namespace kappamu::app {

inline const ImVec4 amber{1.0F, 0.75F, 0.2F, 1.0F};

struct PanelNumbers {
  std::vector<std::string> models;             ///< to choose among
  const render::LiveAnswer* answer = nullptr;  ///< that the picture shows; none yet
  double frame_ms = 0.0;                       ///< drawing and panel
  double waiting_ms = 0.0;                     ///< since something was asked that is not shown
  std::string note;                            ///< what became of the last request, if worth it
  bool photographs = false;                    ///< there are some to show
};

/// Between ImGui's NewFrame and Render. `painter` is none where there is no volume to paint.
Asked draw_panel(const PanelNumbers& numbers, Painter* painter, ViewState& state);

/// Part of draw_panel(): the tool, what an edit does and where, and what is asked.
Asked draw_edits(Painter& painter, ViewState& state);

/// What becomes of unsaved edits when the window is closed.
enum class Closing { undecided, save, discard, go_on };
/// Asks, over everything else.
Closing draw_closing_question();

/// Drag left: orbit, unless the brush is in hand; drag right: the light in hand; wheel: nearer or
/// farther.
void follow_mouse(ViewState& state);

}  // namespace kappamu::app
