// What does not change of a lit block while its κ and μ vary.
#pragma once

#include "core/grid.h"
#include "core/surface_measurements.h"

namespace kappamu::forward {

enum class SourceModel {
  first_collision,  ///< a collimated beam deposits its first collisions along the column below the
                    ///< lit face, reflected to and fro between that and the far one
  boundary          ///< diffuse entry through q = 4 E_t/(1 − R_φ) at the lit face
};
enum class Convention {
  physical,  ///< A = (1+R_j)/(1−R_φ): coefficients comparable with published ones
  wang2008   ///< [W] literally: C = 2.1489, q = E_t, boundary source, exitance reported as π·L of
             ///< [W] (3)
};

struct GridSetup {
  GridShape shape;
  double eta = 1.3;
  Face lit_face = Face::z_minus;
  Sides sides =
      Sides::open;  ///< mirror: no flux through the four faces beside lit_face and its opposite
  SourceModel source = SourceModel::first_collision;
  Convention convention = Convention::physical;

  /// From the lit face to its opposite.
  double thickness_mm() const { return shape.extent(axis_of(lit_face)) * shape.voxel_mm; }
};

}  // namespace kappamu::forward
