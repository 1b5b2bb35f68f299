// The light each pattern sends onto the lit face.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calib/lens/lens.h"
#include "calib/light/radiometry.h"
#include "calib/projector/projector_curve.h"
#include "core/grid.h"
#include "core/image.h"
#include "core/rigid.h"

namespace kappamu::calib {

/// Where the lit face's voxels lie in the projector's image, found once for all patterns: n x n
/// points per voxel, no more than a projector pixel apart and at least 4 x 4.
class LitFace {
 public:
  LitFace(const Lens& projector, const Rigid& projector_from_sample, const GridShape& grid,
          Face face, const FlatField& flat, double projector_black);

  /// Irradiance [v][u] before Fresnel, mean over each voxel, relative to full white at the centre
  /// of the face: flat (black + (1 - black) light[value]), bilinear between projector pixels; 0
  /// where the projector does not reach. `pattern` is grey, of the projector's size, values to 255.
  /// Defocus is not modelled (docs/calibration.md).
  std::vector<float> irradiance(const Image<std::uint16_t>& pattern, const LightTable& light) const;

  /// Part of the lit face's points within the projector's frame.
  double reached() const;

 private:
  struct Point {
    float x = 0.0F;  ///< projector pixel
    float y = 0.0F;
    float white = 0.0F;  ///< irradiance of full white; 0 out of the frame
  };
  int width_;
  int height_;
  std::size_t voxels_;
  int per_voxel_ = 0;
  float black_;
  std::vector<Point> points_;  ///< [voxel][point]
};

}  // namespace kappamu::calib
