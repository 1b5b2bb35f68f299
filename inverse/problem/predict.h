// Predictions of a volume under any light: for validation patterns, and for validating a
// volume on a grid other than the one it was fitted on.
#pragma once

#include <optional>
#include <vector>

#include "core/grid.h"
#include "core/surface_measurements.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

struct PredictOptions {
  Backend backend;
  forward::Convention convention = forward::Convention::physical;
  std::optional<PhotonOptions> photons{};  ///< by transport
  int channel = 0;  ///< of the light, to whose variances, if it has any, photons are as exact
  int refine = 2;   ///< every voxel is split into refine³ before solving; results are means over
                    ///< the surface voxels of `medium`
};

/// [M][v][u] on the seen face, in the quantity of `light`, whose irradiance, faces, sides and eta
/// state the request (its values are not read). Throws InputError when `medium` has another shape.
std::vector<float> predict(const Medium& medium, const SurfaceMeasurements& light,
                           const PredictOptions& options);

}  // namespace kappamu::inverse
