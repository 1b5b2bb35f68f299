// Hair under light: from a texture and its transfer to the radiance that a texel sends to the eye,
// and what an eye above a flat coat sees, by shells or along its ray through every texel. Frame of
// the texture: x, y along the skin, z outwards, lengths in texels.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "forward/shells/reflectance.h"
#include "forward/shells/transfer.h"

namespace kappamu::forward::shells {

/// From root to tip; of each hair brighter or darker by up to `variation` of it. 0 to 1.
struct HairColour {
  Eigen::Array3d root{0.25, 0.15, 0.08}, tip{0.85, 0.65, 0.40};
  double variation = 0.2;

  Eigen::Array3d at(double depth, double shade) const {
    return ((root + depth * (tip - root)) * (1.0 + variation * (2.0 * shade - 1.0))).min(1.0);
  }
};

/// Light from one direction.
struct Lamp {
  Eigen::Vector3d direction;  ///< towards it, of unit length
  Eigen::Array3d irradiance;  ///< on a surface that faces it
};

/// At one place of the skin: each row of `coefficients` belongs to a harmonic; the first three
/// columns are the sky's radiance R, G, B, the others the harmonics of each lamp's direction.
struct PlaceLight {
  Eigen::MatrixXd coefficients;
  std::vector<Lamp> lamps;
};
/// Of lamps without a sky.
PlaceLight light_of(int bands, const std::vector<Lamp>& lamps);

struct LitHair {
  const HairTexture& texture;
  const Transfer& transfer;
  const HairColour& colour;
  const HairReflectance& reflectance;

  /// Radiance towards `eye`, of unit length, of a texel with all its hairs opaque: light that
  /// arrives, once scattered. The sky's is spread evenly over the directions that hairs send it to.
  Eigen::Array3d radiance(std::size_t texel, const PlaceLight& light,
                          const Eigen::Vector3d& eye) const;
  /// The same by rays to the lamps in place of harmonics: the reference.
  Eigen::Array3d radiance_by_rays(std::size_t texel, const std::vector<Lamp>& lamps,
                                  const Eigen::Vector3d& eye) const;
};

using TexelRadiance = std::function<Eigen::Array3d(std::size_t texel)>;

struct SeenHair {
  Eigen::Array3d radiance = Eigen::Array3d::Zero();
  double transmittance = 1.0;  ///< of the skin's light
};

/// How a shell is looked up: as the volume is, even within a texel; smooth between texels, which
/// looks better and spreads hairs by a texel; or smooth between the texels' opacities, as graphics
/// cards filter, which spreads them less.
enum class Lookup { texel, smooth, opacity };

/// A texture's shell at z between texels: weights of four neighbours, their density and the light
/// of those that hold hair.
struct ShellTexels {
  std::array<std::size_t, 4> texel;
  std::array<double, 4> weight;  ///< sum to one
  double density = 0.0;
};
ShellTexels on_shell(const HairTexture& texture, double x, double y, int layer,
                     Lookup lookup = Lookup::smooth);

/// Share of light that a shell holds back: its density over the layer's height, seen aslant.
double opacity(const HairTexture& texture, double r, double density, double cosine);

/// Shells from the top down, alpha-blended ([K] step 3). The ray goes down: direction.z() < 0.
SeenHair seen_by_shells(const HairTexture& texture, double r, const Eigen::Vector3d& origin,
                        const Eigen::Vector3d& direction, const TexelRadiance& radiance,
                        Lookup lookup = Lookup::smooth);
/// The integral along the ray, texel by texel: light scattered once, without shells' error.
SeenHair seen_by_ray(const HairTexture& texture, double r, const Eigen::Vector3d& origin,
                     const Eigen::Vector3d& direction, const TexelRadiance& radiance);

}  // namespace kappamu::forward::shells
