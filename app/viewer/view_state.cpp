#include "app/viewer/view_state.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace kappamu::app {

using Eigen::Vector3d;

render::Selection Region::selection() const {
  switch (kind) {
    case Kind::depth:
      return depth;
    case Kind::box:
      return box;
    case Kind::projection:
      return projection;
    case Kind::texture:
      return texture;
    case Kind::coordinates:
      return coordinates;
    default:
      return render::WholeSelection{};
  }
}

ViewState ViewState::of(const render::Scene& scene, const render::World& world) {
  ViewState state;
  state.lights = scene.lights;
  state.camera = scene.camera;
  Eigen::AlignedBox3d box;
  for (const render::WorldObject& object : world.objects()) {
    for (const Vector3d& vertex : object.mesh.vertices) {
      box.extend(object.world_from_object * vertex);
    }
  }
  state.centre = box.center();
  state.radius_mm = 0.5 * box.diagonal().norm();
  const auto first = std::find_if(state.lights.begin(), state.lights.end(), render::has_angles);
  if (first != state.lights.end()) {
    state.lamp = static_cast<std::size_t>(first - state.lights.begin());
  }
  return state;
}

void ViewState::lay_out(int width, int height, double film_aspect) {
  const float left = docked && panel ? panel_width * scale : 0.0F;
  const float below = docked ? status_height * scale : 0.0F;
  PictureArea whole{left, 0.0F, std::max(1.0F, static_cast<float>(width) - left),
                    std::max(1.0F, static_cast<float>(height) - below)};
  PictureArea half = whole;
  half.width = std::max(1.0F, 0.5F * whole.width);
  half.x += half.width;
  const bool halved = compared != Compared::nothing;
  const auto back = [&](const PictureArea& in) { return std::max(1.0, film_aspect / in.aspect()); };
  if (std::exchange(halved_, halved) != halved) {
    zoom(halved ? back(half) / back(whole) : back(whole) / back(half));
  }
  area = halved ? half : whole;
}

void ViewState::turn_on(double seconds) {
  constexpr double degrees_a_second = 30.0, longest_step_s = 0.2;
  const double turn =
      degrees_a_second * std::min(longest_step_s, seconds) * std::numbers::pi / 180.0;
  drag_light(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()) *
             render::towards(lights[lamp], centre));
}

render::PictureView ViewState::view(float density, int samples) const {
  render::PictureView view;
  view.camera = camera;
  view.width = std::max(1, static_cast<int>(density * area.width));
  view.height = std::max(1, static_cast<int>(density * area.height));
  view.samples = samples;
  return view;
}

void ViewState::orbit(double right_deg, double up_deg) {
  constexpr double degree = std::numbers::pi / 180.0;
  constexpr double nearest_pole = 1.0 * degree;
  const Vector3d up = camera.up.normalized();
  const Vector3d arm = camera.position_mm - camera.target_mm;
  const double distance = arm.norm();
  const double polar = std::acos(std::clamp(arm.dot(up) / distance, -1.0, 1.0));
  const double turned =
      std::clamp(polar - up_deg * degree, nearest_pole, std::numbers::pi - nearest_pole);
  const Vector3d level =
      Eigen::AngleAxisd(right_deg * degree, up) * (arm - arm.dot(up) * up).normalized();
  camera.position_mm =
      camera.target_mm + distance * (std::sin(turned) * level + std::cos(turned) * up);
}

void ViewState::set_light(render::Light light) {
  lights[lamp] = std::move(light);
  lights_changed = true;
}

double ViewState::handle_radius() const {
  constexpr double share = 0.85;  // of the picture's half height or width
  return share * std::tan(0.5 * camera.fov_deg * std::numbers::pi / 180.0) *
         std::min(1.0, area.aspect()) * (camera.position_mm - centre).norm();
}

void ViewState::pan(double right, double up) {
  const Vector3d arm = camera.target_mm - camera.position_mm;
  const Vector3d rightwards = arm.cross(camera.up).normalized();
  const Vector3d upwards = rightwards.cross(arm).normalized();
  const double height =
      2.0 * arm.norm() * std::tan(0.5 * camera.fov_deg * std::numbers::pi / 180.0);
  const Vector3d by = height * (right * rightwards + up * upwards);
  camera.position_mm += by;
  camera.target_mm += by;
}

void ViewState::frame() {
  constexpr double margin = 1.05;
  const double half = std::atan(std::tan(0.5 * camera.fov_deg * std::numbers::pi / 180.0) *
                                std::min(1.0, area.aspect()));
  const Vector3d back = (camera.position_mm - camera.target_mm).normalized();
  camera.target_mm = centre;
  camera.position_mm = centre + margin * radius_mm / std::sin(half) * back;
}

void ViewState::look_along(AxisView view, bool other_side) {
  const Vector3d back = view == AxisView::front   ? Vector3d::UnitZ()
                        : view == AxisView::right ? Vector3d::UnitX()
                                                  : Vector3d::UnitY();
  const double distance = (camera.position_mm - camera.target_mm).norm();
  camera.up = view != AxisView::top ? Vector3d::UnitY()
              : other_side          ? Vector3d::UnitZ()
                                    : Vector3d(-Vector3d::UnitZ());
  camera.target_mm = centre;
  camera.position_mm = centre + (other_side ? -distance : distance) * back;
}

void ViewState::zoom(double factor) {
  camera.position_mm = camera.target_mm + factor * (camera.position_mm - camera.target_mm);
}

}  // namespace kappamu::app
