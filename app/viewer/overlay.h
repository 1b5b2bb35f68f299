// What is drawn over the picture beside the panel: handles of lights, axes, the scale, the brush's
// ring, the line of state, and the list of keys.
#pragma once

#include <imgui.h>

#include <optional>
#include <string>

#include "app/viewer/answers.h"
#include "app/viewer/view_state.h"

namespace kappamu::app {

/// Where a point of the world is seen, in the window; none: behind the camera.
std::optional<ImVec2> on_screen(const ViewState& state, const Eigen::Vector3d& point);

/// Lights, axes and scale.
void draw_marks(const ViewState& state);
/// Over two states side by side, with a line between them.
void draw_names(const ViewState& state, const std::string& left);
/// A ring of a brush's radius about the mouse, where it is over an object of `world`; `text`
/// follows the radius.
void draw_brush_ring(const ViewState& state, const render::World& world, double radius_mm,
                     const std::string& text);
/// Model, error and progress, below the picture. `answer`: none yet.
void draw_status(const ViewState& state, const render::LiveAnswer* answer, double tolerance,
                 const std::optional<Answers::Work>& work);
void draw_keys(ViewState& state);

}  // namespace kappamu::app
