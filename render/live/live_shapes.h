// Shapes of objects that are looked at: those that are asked for, and those that a surface bears.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "render/scene/scene.h"
#include "render/scene/world.h"

namespace kappamu::render {

/// How [M] 5.5 answers: links kept from shape to shape, or all made anew.
enum class FollowBy { update, renewal };

/// Which shapes objects have.
struct ShapeQuestion {
  std::map<std::size_t, std::vector<Deformation>> of{};  ///< of each object that has others now
  /// More shapes follow at once: light is taken at the middles of triangles, the sky's as it was,
  /// and what `most_ms` do not suffice for is left to the next answer. Otherwise the answer is in
  /// full, and a shape that crosses itself is refused.
  bool moving = false;
  double most_ms = 30.0;
  FollowBy by = FollowBy::update;
};

class LiveShapes {
 public:
  explicit LiveShapes(const Scene& scene);

  /// Whether any object has another shape than is asked for.
  bool differ_from(const ShapeQuestion& shape) const;
  /// Moves vertices. Objects whose shape is another now, or is at rest now. One that crosses itself
  /// gets its former shape, and `refused` says why.
  std::vector<std::size_t> set(const ShapeQuestion& shape, World& world, std::string& refused);

  /// Whether the object's shape moves; whether any does.
  bool moves(std::size_t object) const { return moves_[object] != 0; }
  bool any_moves() const;
  /// Vertices of the objects that were moved since the last call.
  std::map<std::size_t, std::vector<Eigen::Vector3d>> take_moved(const World& world);

 private:
  /// Of each object: of the vertices as they are, and as last accepted.
  std::vector<std::vector<Deformation>> shape_, accepted_;
  std::vector<char> moves_, moved_;
};

}  // namespace kappamu::render
