// Fewer shells far away, without popping: shells merge in pairs as fewer are wanted, and look up a
// texture that is halved along all axes as they stand for twice the height.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "forward/shells/lit_hair.h"

namespace kappamu::forward::shells {

/// Shells that are drawn: `count` of them, in pairs that come nearer to each other and whose
/// first takes the second's place as `merged` goes from 0 to 1. Halving the count at 1 changes
/// nothing, so that no shell pops in or out.
struct ShellDetail {
  int count = 32;
  double merged = 0.0;

  /// As many as are `apart_px` pixels apart seen from aside, at least four; `height_px`: of all of
  /// the fur.
  static ShellDetail of(int layers, double height_px, double apart_px = 1.0);

  /// log2 of the layers that one shell stands for: the halved texture that it looks up.
  double level(int layers) const;
  double drawn() const { return count * (1.0 - 0.5 * merged); }
  /// Height of a shell, 0 to 1.
  double height(int i) const { return (i + 0.5 + (i % 2 == 0 ? 0.5 : -0.5) * merged) / count; }
  /// How many of `count` shells it stands for: the exponent of what it lets through.
  double weight(int i) const { return i % 2 == 0 ? 1.0 + merged : 1.0 - merged; }
};

/// Light of texels times their density, and density; halved until a side is odd.
struct LitLevels {
  struct Level {
    int width = 0, layers = 0;
    std::vector<Eigen::Array4d> texels;  ///< [z][y][x]
  };
  std::vector<Level> levels;
  double optical_height = 0.0;  ///< r times the volume's height, dimensionless
  double height = 0.0;          ///< [texel]
  int width = 0;                ///< [texel]
};
LitLevels lit_levels(const HairTexture& texture, double r, const TexelRadiance& radiance);

/// As seen_by_shells() with Lookup::smooth, of these shells; at level 0 all of them.
SeenHair seen_by_detail(const LitLevels& lit, const ShellDetail& detail,
                        const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

}  // namespace kappamu::forward::shells
