// Height of a surface by the shift of projected fringes against a plane's, and what height and tilt
// do to the light that falls on it.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace kappamu::calib {

/// A pinhole projector that looks at the picture's centre, and the sinusoid it shows; the camera
/// looks straight down.
struct FringeProjector {
  double degrees = 0.0;      ///< from the camera's axis, towards `direction` or against it (< 0)
  double distance_mm = 0.0;  ///< of the projector from the picture's centre on the plane
  double per_mm = 0.0;       ///< spatial frequency on the plane
  double direction = 0.0;    ///< of the sinusoid's change [rad], from x towards y
};

struct Relief {
  Image<float> height_mm;  ///< above the plane, towards the camera; 0 where not valid
  /// On the surface over that on the plane at the same pixel: the projector's irradiance, by its
  /// distance and the angle of incidence, and the spatial frequency.
  Image<float> irradiance, frequency;
};

/// `sample` and `plane` are phases [rad] of the same fringes on both (Demodulated::phase). Heights
/// are continuous from pixel to pixel; of their whole, the multiple of a period is taken that puts
/// the median nearest to the plane. Slopes are those of heights averaged by a Gaussian of standard
/// deviation `sigma_px`. Throws InputError for a projector along the camera's axis, which shifts no
/// fringe.
Relief measure_relief(const Image<float>& sample, const Image<float>& plane,
                      const Image<std::uint8_t>& mask, const FringeProjector& projector,
                      double pixel_mm, double sigma_px);

}  // namespace kappamu::calib
