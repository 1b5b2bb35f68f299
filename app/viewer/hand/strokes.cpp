#include "app/viewer/hand/strokes.h"

#include <imgui.h>

#include <cstdio>
#include <utility>

#include "app/viewer/overlay.h"

namespace kappamu::app {

void Strokes::follow(const std::vector<PointerEvent>& events, const Mouse& mouse,
                     const ViewState& state) {
  const render::LookAt look = state.look(state.area.aspect());
  const bool brush = state.tool == Tool::brush && state.region.kind == Region::Kind::stroke;
  const bool free = !ImGui::GetIO().WantCaptureMouse && !mouse.holds_light();
  std::vector<Eigen::Vector2d> points;
  const auto paint = [&](const std::vector<Eigen::Vector2d>& through) {
    editing_.stroke_through(look, through, state.brush);
  };
  for (const PointerEvent& event : events) {
    const Eigen::Vector2d at = state.area.in_picture(event.x, event.y);
    const bool inside = state.area.holds(event.x, event.y);
    if (event.pressed && free && inside && state.tool == Tool::shape) shaping_.press(look, at);
    if (shaping_.pressed()) {
      shaping_.drag(look, at);
      if (!event.left) shaping_.release();
      continue;
    }
    if (event.pressed) stroking_ = brush && free;
    if (stroking_ && inside) points.push_back(at);
    if (event.left || !stroking_) continue;
    paint(std::exchange(points, {}));
    editing_.end_stroke();
    stroking_ = false;
  }
  if (!points.empty()) paint(points);
  const render::World& world = shaping_.world();
  if (brush) {
    char depth[32];
    std::snprintf(depth, sizeof(depth), ", %.3g mm deep", state.brush.depth_mm);
    draw_brush_ring(state, world, state.brush.radius_mm, depth);
  } else if (state.tool == Tool::shape) {
    draw_brush_ring(state, world, shaping_.brush.radius_mm, "");
  }
}

}  // namespace kappamu::app
