#include "app/viewer/shaping.h"

#include <utility>

namespace kappamu::app {

using Eigen::Vector3d;
using render::Deformation;
using render::DeformKind;

Shaping::Shaping(const render::World& world, Painter& painter) : world_(world), painter_(painter) {
  constexpr double usual_radius = 0.2;
  brush.radius_mm = usual_radius * size(0);
}

std::vector<Deformation> Shaping::of(std::size_t object) const {
  return moving_ && moving_->object == object ? moving_->deformations
                                              : painter_.deformations(object);
}

double Shaping::size(std::size_t object) const {
  return bounding_box(world_.objects()[object].rest).sizes().maxCoeff();
}

Deformation Shaping::begun(std::size_t object, DeformKind kind) const {
  constexpr double waves = 5.0;
  const Vector3d box = bounding_box(world_.objects()[object].rest).sizes();
  Eigen::Index longest = 0, shortest = 0;
  box.maxCoeff(&longest);
  box.minCoeff(&shortest);
  if (shortest == longest) shortest = (longest + 1) % 3;
  Deformation deformation;
  deformation.kind = kind;
  deformation.amount = kind == DeformKind::scale ? 1.0 : 0.0;
  deformation.axis = Vector3d::Unit(longest);
  deformation.towards = Vector3d::Unit(shortest);
  deformation.wavelength_mm = box.maxCoeff() / waves;
  return deformation;
}

void Shaping::set(std::size_t object, std::vector<Deformation> deformations, bool moving) {
  changed_ = true;
  if (moving) {
    moving_ = {object, std::move(deformations)};
    return;
  }
  moving_.reset();
  note_.clear();
  std::vector<Deformation> before = painter_.deformations(object);
  if (deformations == before) return;
  painter_.deform(object, deformations);
  made_ = {object, std::move(deformations), std::move(before)};
}

bool Shaping::press(const render::LookAt& look, const Eigen::Vector2d& at) {
  const auto hit = world_.first_hit(look.position(), look.direction(at.x(), at.y()), 0.0);
  if (!hit) return false;
  stroke_ = {hit->object, hit->position};
  Deformation deformation;
  deformation.kind = brush.kind;
  deformation.brush =
      render::DeformBrush{world_.objects()[hit->object].world_from_object.inverse() * hit->position,
                          brush.radius_mm, brush.edge};
  std::vector<Deformation> deformations = of(hit->object);
  deformations.push_back(deformation);
  set(hit->object, std::move(deformations), true);
  return true;
}

void Shaping::drag(const render::LookAt& look, const Eigen::Vector2d& at) {
  if (!stroke_) return;
  // In the plane through the point that was pressed, across the line of sight.
  const Vector3d direction = look.direction(at.x(), at.y());
  const double distance =
      look.forward().dot(stroke_->from - look.position()) / look.forward().dot(direction);
  const Vector3d way = look.position() + distance * direction - stroke_->from;
  std::vector<Deformation> deformations = of(stroke_->object);
  Deformation& last = deformations.back();
  if (last.kind == DeformKind::dent) {
    const Vector3d down = look.direction(0.5, 1.0) - look.direction(0.5, 0.0);
    last.amount = way.dot(down.normalized());
  } else {
    const render::WorldObject& object = world_.objects()[stroke_->object];
    last.amount = way.norm();
    if (last.amount > 0.0) {
      last.axis = object.world_from_object.rotation.transpose() * way / last.amount;
    }
  }
  set(stroke_->object, std::move(deformations), true);
}

void Shaping::release() {
  if (!stroke_) return;
  const std::size_t object = std::exchange(stroke_, std::nullopt)->object;
  set(object, of(object), false);
}

render::ShapeQuestion Shaping::question() const {
  render::ShapeQuestion question;
  for (std::size_t i = 0; i < world_.objects().size(); ++i) question.of[i] = of(i);
  question.moving = moving_.has_value();
  question.by = renewal ? render::FollowBy::renewal : render::FollowBy::update;
  return question;
}

void Shaping::take(const render::LiveAnswer& answer) {
  if (answer.shape_refused.empty()) return;
  note_ = answer.shape_refused + "; the stroke is undone";
  stroke_.reset();
  moving_.reset();
  const std::optional<Made> refused = std::exchange(made_, std::nullopt);
  changed_ = true;
  if (!refused || painter_.deformations(refused->object) != refused->deformations) return;
  painter_.take_back_shape(refused->object, refused->before);
}

}  // namespace kappamu::app
