// Exact integrals over the part of a cube inside a closed triangle mesh.
//
// All that a trilinear element needs are the 27 moments ∫ x^a y^b z^c, a, b, c ≤ 2, over the volume
// and over the surface inside the cube. Volume moments follow from the surface by the divergence
// theorem, applied once per dimension: the volume from the surface pieces and the cube's upper z
// face, that face from the pieces' edges in it and its upper y edge, that edge from its crossings
// and the state of the corner (1, 1, 1).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "forward/embedded/geometry/triangle_clip.h"

namespace kappamu::forward::embedded {

/// [a + 3 b + 9 c], in coordinates where the cube is [0, 1]³.
using Moments = std::array<double, 27>;

/// The part of one triangle inside a cube.
struct SurfacePiece {
  int triangle = 0;
  /// ∫ N_i dA of the eight trilinear shape functions, x fastest, in units of the cube's face.
  std::array<double, 8> weight{};
};

/// Of a cube: inside the mesh or outside.
enum class Corner { inside, outside };

class CutCell {
 public:
  /// Adds what is inside the unit cube of a triangle, vertices counter-clockwise seen from outside.
  void add(int triangle, const Triangle& corners);

  const std::vector<SurfacePiece>& pieces() const { return pieces_; }
  const Moments& surface() const { return surface_; }
  /// Where the corner (1, 1, 1) is; none where the surface cuts off so little that rounding hides
  /// it.
  std::optional<Corner> corner() const;
  Moments volume(Corner corner) const;

 private:
  void add_edge(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

  std::vector<SurfacePiece> pieces_;
  Moments surface_{};
  // What the volume, upper face and upper edge would be with the corner outside.
  Moments volume_{};
  std::array<double, 9> face_{};  ///< [a + 3 b]
  std::array<double, 3> edge_{};
};

}  // namespace kappamu::forward::embedded
