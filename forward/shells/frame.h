// A flat coat drawn fast: all texels are lit once a frame, then shells are blended from the top
// down through a pinhole ([K] 2.4 and step 3; [K] lights every fragment). The skin is black.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "forward/shells/lit_hair.h"

namespace kappamu::forward::shells {

class FrameDrawer {
 public:
  /// Keeps references to texture and transfer. At most 64 layers.
  FrameDrawer(const HairTexture& texture, const Transfer& transfer, const HairColour& colour,
              int width, int height);

  /// Radiance R, G, B times density, and density; [texel].
  using Texels = std::vector<Eigen::Array4f>;

  /// The sky's light and lamps' towards one eye far away, of unit length.
  Texels lit(const PlaceLight& light, const Eigen::Vector3d& eye,
             const HairReflectance& reflectance) const;
  /// From `eye` towards `target` [texel], z up; `fov_deg` of the height.
  Image<float> drawn(const Texels& lit, const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                     double fov_deg) const;

 private:
  Eigen::Array4f seen(const Texels& lit, const Eigen::Vector3f& origin,
                      const Eigen::Vector3f& direction) const;

  const HairTexture& texture_;
  const Transfer& transfer_;
  HairColour colour_;
  int width_, height_;
  std::vector<std::uint64_t> filled_;  ///< [y][x]: layers with hair in the four texels from there
  std::vector<float> left_;            ///< e^−τ, tabulated
};

}  // namespace kappamu::forward::shells
