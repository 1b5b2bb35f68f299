// The pressed left button over fur, where it leads the brush.
#pragma once

#include <optional>
#include <vector>

#include "app/viewer/editing.h"
#include "app/viewer/fur/fur_model.h"
#include "app/viewer/hand/mouse.h"
#include "app/viewer/view_state.h"
#include "app/viewer/window.h"

namespace kappamu::app {

class FurHand {
 public:
  /// Keeps references.
  FurHand(FurModel& model, Editing& editing) : model_(model), editing_(editing) {}

  /// Between ImGui's NewFrame and Render, after the mouse has taken what it holds.
  void follow(const std::vector<PointerEvent>& events, const Mouse& mouse, const ViewState& state);

 private:
  /// The stroke becomes an edit.
  void end();

  FurModel& model_;
  Editing& editing_;
  std::optional<Eigen::Vector2d> at_;  ///< of the picture, where the stroke has come to
};

}  // namespace kappamu::app
