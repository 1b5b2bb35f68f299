// Local diffusion ([T] 3.4) as a way to sum the dipole: samples about every triangle, in image
// space where the picture's eye sees what matters, else over the surface.
#pragma once

#include <vector>

#include "forward/dipole/profile/profile.h"
#include "forward/object_model.h"

namespace kappamu::forward::dipole {

/// Fills exitance, standard error, error estimate, elements (samples), iterations, seconds and
/// message. Samples are added until the noise over the surface, and the error at some triangles
/// against the direct sum, meet the tolerance. `irradiance`: after the surface, [light][triangle].
///
/// With `options.eye` triangles that it sees are summed in image space, if what the eye does not
/// see changes them by less than half the tolerance, which the direct sum with and without it
/// measures.
void sum_locally(const ObjectProblem& problem, const ObjectOptions& options, const Profile& profile,
                 const std::vector<std::vector<double>>& irradiance, Progress& progress,
                 ObjectResult& result);

}  // namespace kappamu::forward::dipole
