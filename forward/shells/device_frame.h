// The flat coat of frame.h drawn by an OpenCL device (opencl/shells.cl): texels are lit and
// premultiplied once a frame, in 16 bits, then blended from the top down until a pixel is opaque.
// Texels hold opacity, so hair between texels is opaque as their mean, where FrameDrawer has the
// opacity of their mean density; premultiplied() and blended() are the plain reference.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "device/context.h"
#include "forward/shells/frame.h"

namespace kappamu::forward::shells {

class DeviceFrame {
 public:
  /// Keeps references. At most 64 layers; throws InputError otherwise, and where the device lacks
  /// memory.
  DeviceFrame(device::Context& context, const HairTexture& texture, const Transfer& transfer,
              const HairColour& colour, int width, int height);

  /// Towards one eye far away, of unit length. Reflectance `marschner` is computed by the host.
  void light(const PlaceLight& light, const Eigen::Vector3d& eye,
             const HairReflectance& reflectance);
  /// As FrameDrawer::drawn(), which states the arguments; not yet read back. Rays that meet the
  /// skin at less than a thousandth see nothing. Where a texel is several pixels wide in all of the
  /// frame, rays are two pixels apart and the pixels between them interpolated, unless
  /// `every_pixel` has a ray of its own.
  void draw(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, double fov_deg,
            bool every_pixel = false);
  int rays_apart() const { return apart_; }  ///< of the frame drawn last [pixel]
  /// The frame drawn last: R, G, B of `white`, and opacity, each of 65535; [y][x][4], rows padded
  /// to a multiple of 16 pixels.
  template <class Look>
  void look(const Look& look) {
    context_.look(seen_, seen_.bytes(), look);
  }
  Image<float> picture();

  double white() const { return white_; }  ///< largest radiance of a texel

 private:
  void upload_hair();
  void mark_filled(const Eigen::Array2d& group);

  device::Context& context_;
  const HairTexture& texture_;
  const Transfer& transfer_;
  HairColour colour_;
  int width_, height_, items_ = 0, apart_ = 1;
  std::array<int, 4> marked_{};  ///< texels to the left, right, front and back
  double white_ = 1.0;
  std::vector<std::size_t> texel_;  ///< with hair, in the order of the device; the last repeats
  device::Program* program_;
  device::Buffer hair_, transfer_values_, depth_, place_, lit_, texels_, filled_, rays_, seen_;
};

}  // namespace kappamu::forward::shells
