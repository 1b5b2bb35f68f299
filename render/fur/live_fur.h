// Fur for a graphics card: the tile as three volumes of four channels, its transfer reduced to a
// few modes, and the corners of the skin's triangles with the light that arrives there. A fragment
// then costs three lookups per patch and a dot product per lamp, where [K] has 25 coefficients.
//
// The modes are the eigenvectors of the transfer's second moments over the hair (Sloan et al. 2003,
// without clusters): t = Σ_k w_k e_k, and light l arrives as Σ_k w_k (e_k · l).
#pragma once

#include <array>
#include <vector>

#include "forward/shells/detail.h"
#include "render/fur/furry_object.h"

namespace kappamu::render {

struct FurVolume {
  static constexpr int modes = 5;
  int width = 0, layers = 0;
  double r = 0.0;             ///< [1/texel]
  double layer_height = 1.0;  ///< [texel]
  /// [z][y][x][4], each times the texel's density ρ: (1, depth, shade, w₀), (tangent, w₁),
  /// (w₂, w₃, w₄, 0).
  std::array<std::vector<float>, 3> texels;
  Eigen::MatrixXd basis;  ///< a mode per column
  double lost = 0.0;      ///< share of the transfer's squared norm that the modes leave out
};
FurVolume make_fur_volume(const FurTile& tile);

struct FurCorners {
  /// Position [mm], outward normal and comb in the world; tile coordinates and weight of four
  /// patches; length [mm], density and colour R, G, B of the coat.
  static constexpr int geometry_floats = 26;
  /// Sky: a mode's R, G, B after the other; two lamps: modes, direction in the skin's frame, and
  /// irradiance over the lamp's colour. Further lamps are added to the sky, whose light hair sends
  /// on evenly.
  static constexpr int light_floats = 3 * FurVolume::modes + 2 * (FurVolume::modes + 4);

  std::vector<float> geometry;  ///< [corner][geometry_floats], three per triangle
  std::vector<float> light;     ///< [corner][light_floats]
  std::array<Eigen::Array3f, 2> lamp_colour;
};
std::vector<float> fur_geometry(const FurryObject& object);
/// After FurryObject::set_light(). Fills light and lamp_colour.
void light_fur(const FurryObject& object, const FurVolume& volume, FurCorners& corners);

/// Share of the skin's light at each vertex that the fur above it lets arrive, by the lamps and the
/// sky that arrive there.
std::vector<double> skin_shares(const FurryObject& object);

}  // namespace kappamu::render
