#include "app/viewer/view_state.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

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
    default:
      return render::WholeSelection{};
  }
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

void ViewState::zoom(double factor) {
  camera.position_mm = camera.target_mm + factor * (camera.position_mm - camera.target_mm);
}

}  // namespace kappamu::app
