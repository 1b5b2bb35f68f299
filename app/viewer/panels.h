// All that is drawn over and beside the picture: marks, the line of state, the panel's groups,
// slices and photographs.
#pragma once

#include <optional>
#include <string>

#include "app/viewer/comparison.h"
#include "app/viewer/editing.h"
#include "app/viewer/panel.h"
#include "app/viewer/panel/photographs.h"
#include "app/viewer/panel/slice_window.h"
#include "app/viewer/shaping.h"

namespace kappamu::app {

class Panels {
 public:
  /// Keeps references. `home`: the camera that slices stand upright in.
  Panels(render::LiveScene& live, const ViewerOptions& options, Editing& editing, Shaping& shaping,
         Shown& shown, const render::Camera& home);

  /// Patterns of a run that can be shown.
  int photograph_count() const { return photographs_ ? photographs_->count() : 0; }
  /// Between ImGui's NewFrame and Render. `note` goes before that of the edits.
  void draw(const Beside& beside, double frame_ms, const std::string& note, ViewState& state);

 private:
  const render::LiveScene& live_;
  Editing& editing_;
  const Shown& shown_;
  const render::Camera home_;
  PanelGroups groups_;
  SliceWindow slices_;
  std::optional<PhotographWindow> photographs_;
};

}  // namespace kappamu::app
