// The panel beside the picture: groups under headings.
#pragma once

#include <imgui.h>

#include <memory>
#include <string>
#include <vector>

#include "app/viewer/view_state.h"
#include "render/live/live_scene.h"

namespace kappamu::app {

inline const ImVec4 amber{1.0F, 0.75F, 0.2F, 1.0F};

class Shaping;

/// What the panel states.
struct PanelNumbers {
  const render::LiveAnswer* answer = nullptr;  ///< that the picture shows; none yet
  double frame_ms = 0.0;                       ///< drawing and panel
  std::string note;                            ///< what became of the last request, if worth it
};

/// One group of the panel. It changes the state, and returns what else is asked of the window. The
/// window itself sees where lights or the model were changed.
class PanelGroup {
 public:
  virtual ~PanelGroup() = default;
  virtual const char* title() const = 0;
  /// Between ImGui's NewFrame and Render.
  virtual Asked draw(const PanelNumbers& numbers, ViewState& state) = 0;
};

/// The light in hand, its angles.
std::unique_ptr<PanelGroup> light_group();
/// Exposure and channels; `photographs`: there are some to show.
std::unique_ptr<PanelGroup> view_group(bool photographs);
/// The model among `models`, and what its last answer cost.
std::unique_ptr<PanelGroup> model_group(std::vector<std::string> models);
/// Deformations of the objects and the brush that makes them. Keeps a reference.
std::unique_ptr<PanelGroup> shape_group(Shaping& shaping);
/// The tool, what an edit does and where. Keeps a reference.
std::unique_ptr<PanelGroup> edit_group(Painter& painter);
/// The material of all of the object in hand, and its surface. Keeps a reference.
std::unique_ptr<PanelGroup> material_group(Painter& painter);

using PanelGroups = std::vector<std::unique_ptr<PanelGroup>>;

/// All groups in order. What the last of them asked.
Asked draw_panel(const PanelGroups& groups, const PanelNumbers& numbers, ViewState& state);

/// What becomes of unsaved edits when the window is closed.
enum class Closing { undecided, save, discard, go_on };
/// Asks, over everything else.
Closing draw_closing_question();

}  // namespace kappamu::app
