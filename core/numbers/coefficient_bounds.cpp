#include "core/numbers/coefficient_bounds.h"

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu {

void require_usual_voxel(double voxel_mm, const std::string& source) {
  if (voxel_mm >= least_voxel_mm && voxel_mm <= most_voxel_mm) return;
  throw InputError(source + formatted(": the voxels' edge is %g mm; it must lie between %g and %g",
                                      voxel_mm, least_voxel_mm, most_voxel_mm));
}

void require_usual_light(double brightest, const std::string& source) {
  if (brightest == 0.0 || (brightest >= least_light && brightest <= most_light)) return;
  throw InputError(source + ": irradiance is at most " + shown_number(brightest, "%g") +
                   ", beyond 1e-20 to 1e20; state it in another unit");
}

}  // namespace kappamu
