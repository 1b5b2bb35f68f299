// How the hair of one object differs from place to place: length, density, colour and combing, from
// images by the mesh's texture coordinates, or by a brush.
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

/// Ones and no turn, but where the fur has images. A vertex at a seam has the mean of its corners.
/// Throws InputError naming the image's field where the mesh has no texture coordinates, and as
/// io::read_relative_image().
Coat coat_of(const TriangleMesh& mesh, const Fur& fur);

}  // namespace kappamu::render
