// How the hair of one object differs from place to place: length, density, colour and combing, from
// images by the mesh's texture coordinates, and strokes of a brush after them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// Per vertex of the mesh; between vertices it is interpolated.
struct Coat {
  std::vector<float> length;           ///< of the fur's length, 0 to 1
  std::vector<float> density;          ///< of the hair that a texel holds, 0 to 1
  std::vector<Eigen::Array3f> colour;  ///< of the hair's colour, R, G, B, 0 to 1
  std::vector<float> turn;             ///< of the comb about the outward normal [rad]
};

/// The coat of a fur whose strokes grow and change: what it has drawn it keeps as long as it can.
/// The result is the same to the last bit whatever it was asked before.
class CoatPainter {
 public:
  /// Of the undeformed mesh, whose reference it keeps. Reads the fur's images. Throws InputError
  /// naming the image's field where the mesh has no texture coordinates, and as
  /// io::read_relative_image().
  CoatPainter(const TriangleMesh& rest, const Fur& fur);

  /// Of a fur with the same images.
  const Coat& of(const Fur& fur);

 private:
  bool goes_on(const Fur& fur) const;
  void draw(const FurStroke& stroke, std::size_t first_point);

  const TriangleMesh& rest_;
  Coat bare_, coat_;  ///< without strokes, and with those drawn
  std::vector<FurStroke> drawn_;
  std::vector<Eigen::Matrix3d> frames_;  ///< of the undeformed skin, where combing begins
  Eigen::Vector3d comb_ = Eigen::Vector3d::Zero();
  double comb_turn_deg_ = 0.0;
};

/// Ones and no turn, but where the fur has images and strokes. A vertex at a seam has the mean of
/// its corners. Throws as CoatPainter.
Coat coat_of(const TriangleMesh& rest, const Fur& fur);

}  // namespace kappamu::render
