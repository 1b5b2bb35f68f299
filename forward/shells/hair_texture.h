// A tile of hair as a volume texture ([K] 2.1): what share of each texel hairs fill, their tangent
// and how far from the root they are. The tile repeats along x and y without a seam; z points out
// of the skin. Lengths are in texels, whose squares have edges of one.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace kappamu::forward::shells {

/// Hairs of one kind. A hair's place within both ranges is the same: the thicker, the longer.
struct HairCoat {
  int hairs = 0;                             ///< in the tile
  double least_radius = 0, most_radius = 0;  ///< at the root [texel]; at most half a texel
  double least_length = 0, most_length = 0;  ///< share of the volume's height, at most 1
  double curl = 0;  ///< the tip's largest distance from a straight hair, over the hair's height
};

struct HairOptions {
  int width = 64;             ///< texels along x and y
  int layers = 32;            ///< along z
  double layer_height = 1.0;  ///< [texel]
  /// Dense and thin below, sparse and thick above: 55,000 hairs, as [K] figure 1.
  std::vector<HairCoat> coats{{53'800, 0.04, 0.09, 0.05, 0.35, 0.3},
                              {1'200, 0.20, 0.45, 0.5, 1.0, 0.3}};
  /// Where hairs lean: displacement over height, by the root's place in [0, 1)². Empty: upright.
  std::function<Eigen::Vector2d(double x, double y)> lean;
  std::uint64_t seed = 1;
};

/// [z][y][x], x fastest.
struct HairTexture {
  int width = 0, layers = 0;
  double layer_height = 1.0;             ///< [texel]
  std::vector<float> density;            ///< ρ: share of the texel that hairs fill, 0 to 1
  std::vector<float> depth;              ///< 0 at the root to 1 at the tip, mean over the hairs
  std::vector<float> shade;              ///< a random number of each hair, mean over the hairs
  std::vector<Eigen::Vector3f> tangent;  ///< of unit length, mean over the hairs; zero in air
  /// Width over cross-section, of all hairs [1/texel]: with it as r, light that crosses the hairs
  /// is attenuated as opaque cylinders of those widths do.
  double extinction = 0.0;
  double overfull = 0.0;  ///< share of the hairs' volume in texels that were full already
  double thin = 0.0;  ///< share of the hairs' volume where they are thinner than a tenth of a texel

  std::size_t size() const { return density.size(); }
  std::size_t texel(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * width + y) * static_cast<std::size_t>(width) + x;
  }
  double height() const { return layers * layer_height; }
};

/// Throws InputError naming option and bound. Equal options give equal bits.
HairTexture make_hair_texture(const HairOptions& options);

}  // namespace kappamu::forward::shells
