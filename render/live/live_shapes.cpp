#include "render/live/live_shapes.h"

#include <algorithm>

#include "core/error.h"

namespace kappamu::render {

LiveShapes::LiveShapes(const Scene& scene) {
  for (const SceneObject& object : scene.objects) shape_.push_back(object.deform);
  accepted_ = shape_;
  moves_.assign(shape_.size(), 0);
  moved_ = moves_;
}

bool LiveShapes::differ_from(const ShapeQuestion& shape) const {
  return std::any_of(shape.of.begin(), shape.of.end(),
                     [&](const auto& one) { return one.second != shape_[one.first]; });
}

std::vector<std::size_t> LiveShapes::set(const ShapeQuestion& shape, World& world,
                                         std::string& refused) {
  std::vector<std::size_t> others;
  for (const auto& [object, asked] : shape.of) {
    if (asked == shape_[object] && (shape.moving || !moves(object))) continue;
    const WorldObject& lit = world.objects()[object];
    shape_[object] = asked;
    TriangleMesh mesh;
    try {
      const bool known = shape.moving || asked == accepted_[object];
      mesh = known ? deformed(lit.rest, asked) : deformed_body(lit.rest, asked);
      if (!shape.moving) accepted_[object] = asked;
    } catch (const InputError& refusal) {
      refused = "object '" + lit.name + "': " + refusal.what();
      shape_[object] = accepted_[object];
      mesh = deformed(lit.rest, accepted_[object]);
    }
    world.move(object, std::move(mesh.vertices));
    moves_[object] = shape.moving ? 1 : 0;
    moved_[object] = 1;
    others.push_back(object);
  }
  return others;
}

bool LiveShapes::any_moves() const {
  return std::find(moves_.begin(), moves_.end(), 1) != moves_.end();
}

std::map<std::size_t, std::vector<Eigen::Vector3d>> LiveShapes::take_moved(const World& world) {
  std::map<std::size_t, std::vector<Eigen::Vector3d>> moved;
  for (std::size_t i = 0; i < moved_.size(); ++i) {
    if (moved_[i] != 0) moved[i] = world.objects()[i].mesh.vertices;
    moved_[i] = 0;
  }
  return moved;
}

}  // namespace kappamu::render
