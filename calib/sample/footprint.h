// Which camera pixels show a surface voxel, and with what weight.
#pragma once

#include <cstdint>
#include <vector>

#include "calib/lens/lens.h"
#include "core/grid.h"
#include "core/rigid.h"

namespace kappamu::calib {

/// The voxels of a face in the picture, as rows of a sparse matrix from pixels to voxel means.
///
/// A voxel's mean is the integral of the bilinearly interpolated picture over its quadrilateral, by
/// points less than half a pixel apart, divided by the same integral of the face's own coverage of
/// the pixels. Coverage is 1 inside and falls to 0 across the face's edge, so a rim voxel is not
/// darkened by the background its pixels also show.
struct Footprints {
  FaceShape shape;
  std::vector<std::size_t> begin;        ///< [voxel + 1] into `pixel` and `weight`
  std::vector<std::uint32_t> pixel;      ///< y * width + x
  std::vector<float> weight;             ///< of the pixel; times `inverse_coverage` they average
  std::vector<double> inverse_coverage;  ///< [voxel] 1 inside, more on the rim
  std::vector<double> cos_outside;       ///< [voxel] of the viewing direction to the face's normal
  /// [voxel] 1 unless the voxel is out of the picture or seen from behind
  std::vector<std::uint8_t> visible;
  double pixels_per_voxel = 0.0;  ///< edge of the middle voxel in pixels
};

Footprints make_footprints(const Lens& camera, const Rigid& camera_from_sample,
                           const GridShape& grid, Face face);

}  // namespace kappamu::calib
