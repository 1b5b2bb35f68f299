// The pressed left button over fur, where it leads the brush.
#pragma once

#include <optional>
#include <vector>

#include "app/viewer/fur/fur_model.h"
#include "app/viewer/hand/mouse.h"
#include "app/viewer/view_state.h"
#include "app/viewer/window.h"

namespace kappamu::app {

class FurHand {
 public:
  /// Keeps a reference.
  explicit FurHand(FurModel& model) : model_(model) {}

  /// Between ImGui's NewFrame and Render, after the mouse has taken what it holds.
  void follow(const std::vector<PointerEvent>& events, const Mouse& mouse, const ViewState& state);

 private:
  FurModel& model_;
  std::optional<Eigen::Vector2d> at_;  ///< of the picture, where the stroke has come to
};

}  // namespace kappamu::app
