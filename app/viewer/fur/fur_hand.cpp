#include "app/viewer/fur/fur_hand.h"

#include <imgui.h>

#include <utility>

#include "app/viewer/overlay.h"

namespace kappamu::app {

void FurHand::follow(const std::vector<PointerEvent>& events, const Mouse& mouse,
                     const ViewState& state) {
  if (state.tool != Tool::fur) return end();
  const render::LookAt look = state.look(state.area.aspect());
  const bool free = !ImGui::GetIO().WantCaptureMouse && !mouse.holds_light();
  for (const PointerEvent& event : events) {
    const Eigen::Vector2d at = state.area.in_picture(event.x, event.y);
    if (event.pressed && free) at_ = at;
    // A brush needs a way to go: a comb's direction.
    if (at_ && (at - *at_).norm() >= 0.005) {
      model_.stroke(look, *at_, at);
      at_ = at;
    }
    if (!event.left) end();
  }
  draw_brush_ring(state, model_.world(), model_.brush.radius_mm, "");
}

void FurHand::end() {
  if (!std::exchange(at_, std::nullopt)) return;
  for (const auto& [object, change] : model_.end_stroke()) editing_.change_fur(object, change);
}

}  // namespace kappamu::app
