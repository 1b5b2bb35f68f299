#include "app/viewer/overlay.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/viewer/panel.h"
#include "app/viewer/panel/shown_error.h"

namespace kappamu::app {

namespace {

using Eigen::Vector3d;

constexpr ImU32 pale = IM_COL32(230, 230, 230, 255), dim = IM_COL32(160, 160, 160, 255),
                black = IM_COL32(0, 0, 0, 255);

/// Text that can be read on pale and on dark objects.
void write(ImDrawList& list, const ViewState& state, ImVec2 at, ImU32 colour,
           const std::string& words) {
  list.AddText({at.x + state.scale, at.y + state.scale}, black, words.c_str());
  list.AddText(at, colour, words.c_str());
}

/// Millimetres that a pixel stands for, at this distance along the line of sight.
double mm_per_pixel(const ViewState& state, double distance_mm) {
  const double half = std::tan(0.5 * state.camera.fov_deg * std::numbers::pi / 180.0);
  return 2.0 * distance_mm * half / state.area.height;
}

ImU32 colour_of(const render::Colour& colour) {
  const render::Colour shown = colour / std::max(1e-12, colour.maxCoeff());
  const auto byte = [&](Eigen::Index c) {
    return static_cast<int>(255.0 * std::pow(std::clamp(shown[c], 0.0, 1.0), 1.0 / 2.2));
  };
  return IM_COL32(byte(0), byte(1), byte(2), 255);
}

void draw_lights(const ViewState& state, ImDrawList& list) {
  const auto centre = on_screen(state, state.centre);
  for (std::size_t i = 0; i < state.lights.size(); ++i) {
    const auto at = on_screen(state, state.handle_of(i));
    if (!at || !centre) continue;
    const bool in_hand = i == state.lamp;
    const ImU32 colour = colour_of(render::intensity_of(state.lights[i]));
    const float radius = (in_hand ? 7.0F : 5.0F) * state.scale;
    const ImVec2 inwards{centre->x - at->x, centre->y - at->y};
    const float length = std::max(1.0F, std::hypot(inwards.x, inwards.y));
    const float arrow = std::min(0.5F * length, 30.0F * state.scale) / length;
    const ImVec2 tip{at->x + arrow * inwards.x, at->y + arrow * inwards.y};
    list.AddLine(*at, tip, black, 3.5F * state.scale);
    list.AddLine(*at, tip, colour, 1.5F * state.scale);
    list.AddCircleFilled(*at, radius + 2.5F * state.scale, black);
    list.AddCircleFilled(*at, radius, colour);
    list.AddCircle(*at, radius + 1.5F * state.scale, in_hand ? pale : dim, 0, state.scale);
    const std::string name = std::to_string(i + 1) + " " + render::kind_of(state.lights[i]);
    write(list, state, {at->x + radius + 4.0F * state.scale, at->y - 7.0F * state.scale},
          in_hand ? pale : dim, name);
  }
}

void draw_axes(const ViewState& state, ImDrawList& list) {
  const render::Camera& camera = state.camera;
  const Vector3d forward = (camera.target_mm - camera.position_mm).normalized();
  const Vector3d right = forward.cross(camera.up).normalized();
  const Vector3d up = right.cross(forward);
  const float length = 28.0F * state.scale;
  const ImVec2 at{state.area.x + 1.6F * length, state.area.y + state.area.height - 1.6F * length};
  constexpr ImU32 colours[] = {IM_COL32(230, 90, 80, 255), IM_COL32(110, 190, 90, 255),
                               IM_COL32(90, 140, 240, 255)};
  constexpr const char* names[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto x = length * static_cast<float>(right[axis]);
    const auto y = -length * static_cast<float>(up[axis]);
    const ImVec2 tip{at.x + x, at.y + y};
    list.AddLine(at, tip, colours[axis], 2.0F * state.scale);
    list.AddText({tip.x + 0.2F * x - 3.0F, tip.y + 0.2F * y - 7.0F}, colours[axis], names[axis]);
  }
}

/// A bar of 1, 2 or 5 times a power of ten, about a sixth of the picture wide, true at the centre.
void draw_scale(const ViewState& state, ImDrawList& list) {
  const double per_pixel = mm_per_pixel(state, (state.camera.position_mm - state.centre).norm());
  const double longest = per_pixel * static_cast<double>(state.area.width) / 6.0;
  double length = std::pow(10.0, std::floor(std::log10(longest)));
  if (5.0 * length <= longest) {
    length *= 5.0;
  } else if (2.0 * length <= longest) {
    length *= 2.0;
  }
  const auto pixels = static_cast<float>(length / per_pixel);
  const ImVec2 end{state.area.x + state.area.width - 16.0F * state.scale,
                   state.area.y + state.area.height - 16.0F * state.scale};
  list.AddLine({end.x - pixels, end.y}, end, pale, 2.0F * state.scale);
  for (const float x : {end.x - pixels, end.x}) {
    list.AddLine({x, end.y - 4.0F * state.scale}, {x, end.y + 4.0F * state.scale}, pale,
                 2.0F * state.scale);
  }
  char text[32];
  std::snprintf(text, sizeof(text), "%g mm", length);
  write(list, state, {end.x - pixels, end.y - 20.0F * state.scale}, pale, text);
}

}  // namespace

std::optional<ImVec2> on_screen(const ViewState& state, const Vector3d& point) {
  const render::Camera& camera = state.camera;
  const Vector3d forward = (camera.target_mm - camera.position_mm).normalized();
  const Vector3d right = forward.cross(camera.up).normalized();
  const Vector3d up = right.cross(forward);
  const Vector3d arm = point - camera.position_mm;
  const double depth = arm.dot(forward);
  if (depth <= 0.0) return std::nullopt;
  const double per_pixel = mm_per_pixel(state, depth);
  const PictureArea& area = state.area;
  return ImVec2{area.x + 0.5F * area.width + static_cast<float>(arm.dot(right) / per_pixel),
                area.y + 0.5F * area.height - static_cast<float>(arm.dot(up) / per_pixel)};
}

void draw_marks(const ViewState& state) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const PictureArea& area = state.area;
  list.PushClipRect({area.x, area.y}, {area.x + area.width, area.y + area.height});
  draw_lights(state, list);
  draw_axes(state, list);
  draw_scale(state, list);
  list.PopClipRect();
}

void draw_names(const ViewState& state, const std::string& left) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const PictureArea& area = state.area;
  list.AddLine({area.x, area.y}, {area.x, area.y + area.height}, pale, state.scale);
  const float margin = 8.0F * state.scale;
  list.PushClipRect({area.x - area.width, area.y}, {area.x - margin, area.y + area.height});
  write(list, state, {area.x - area.width + margin, area.y + margin}, pale, left);
  list.PopClipRect();
  write(list, state, {area.x + margin, area.y + margin}, pale, "now");
}

void draw_brush_ring(const ViewState& state, const render::World& world, double radius_mm,
                     const std::string& text) {
  const ImVec2 mouse = ImGui::GetMousePos();
  const double x = static_cast<double>(mouse.x), y = static_cast<double>(mouse.y);
  if (ImGui::GetIO().WantCaptureMouse || !state.area.holds(x, y)) return;
  const render::LookAt look = state.look(state.area.aspect());
  const Eigen::Vector2d at = state.area.in_picture(x, y);
  const Vector3d direction = look.direction(at.x(), at.y());
  const auto hit = world.first_hit(look.position(), direction, 0.0);
  if (!hit) return;
  const double depth = hit->distance * direction.dot(look.forward());
  const auto radius = static_cast<float>(radius_mm / mm_per_pixel(state, depth));
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  char length[32];
  std::snprintf(length, sizeof(length), "%.3g mm", radius_mm);
  const std::string words = length + text;
  const ImVec2 beside{mouse.x + radius + 4.0F * state.scale, mouse.y - 7.0F * state.scale};
  list.AddCircle(mouse, radius + state.scale, black, 0, state.scale);
  list.AddCircle(mouse, radius, pale, 0, state.scale);
  write(list, state, beside, pale, words);
}

void draw_status(const ViewState& state, const render::LiveAnswer* answer, double tolerance,
                 const std::optional<Answers::Work>& work) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.0F, size.y - status_height * state.scale});
  ImGui::SetNextWindowSize({size.x, status_height * state.scale});
  ImGui::Begin("state", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
  if (answer == nullptr) {
    ImGui::TextUnformatted("shape only, no light yet");
  } else {
    ImGui::Text("%s, %zu elements", answer->model.c_str(), answer->elements);
    ImGui::SameLine();
    if (const auto error = answer->error()) {
      ImGui::Text("| error up to %s (asked %.2g %%)", shown_error(*error).c_str(),
                  100.0 * tolerance);
    } else {
      ImGui::TextUnformatted("| error not known yet");
    }
  }
  ImGui::SameLine();
  if (work) {
    ImGui::TextColored(amber, "| %s%s %s %.0f %%, %.1f s",
                       work->refining ? "sharpening: " : "solving: ", work->stage.c_str(),
                       work->detail.c_str(), 100.0 * work->fraction, work->seconds);
  } else {
    ImGui::TextUnformatted("| at rest");
  }
  ImGui::SameLine();
  ImGui::TextDisabled("| F1: keys");
  ImGui::End();
}

void draw_keys(ViewState& state) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * size.x, 0.5F * size.y}, ImGuiCond_Appearing, {0.5F, 0.5F});
  ImGui::Begin("keys and mouse", &state.keys_shown, ImGuiWindowFlags_AlwaysAutoResize);
  constexpr const char* list[][2] = {
      {"drag left or middle", "orbit"},
      {"Shift + drag left or middle", "pan"},
      {"drag right, Ctrl + drag middle, wheel", "zoom"},
      {"drag a light's mark", "turn the light about the object"},
      {"Tab", "take the next light in hand"},
      {"Space", "turn the light in hand round; again: stop"},
      {"F", "frame the object"},
      {"1, 3, 7", "look from the front, the right, the top; with Ctrl from the other side"},
      {"0", "the scene's own view"},
      {"B", "brush on or off"},
      {"C", "the unedited scene beside it, on or off"},
      {"Ctrl+Z, Ctrl+Shift+Z or Ctrl+Y", "undo, redo"},
      {"Ctrl+S", "save edits"},
      {"N", "panel on or off"},
      {"drop a scene, a run or a mesh", "open it"},
      {"F1", "this list"},
  };
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const auto& [key, does] : list) {
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(key);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(does);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace kappamu::app
