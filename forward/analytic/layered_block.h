// The forward model `analytic`: a block with mirror sides whose coefficients depend on the depth
// alone, solved exactly by cosine series across the light and layer by layer along it.
//
// Mirror sides make cos(mπx/X) cos(nπy/Y) the lateral modes. The irradiance is constant on every
// pixel, so its series does not end: frequency m of the pixels' own discrete cosine transform
// stands for all frequencies 2jN ± m, each weighted by the pixel's sinc at both ends, once because
// the light is a pixel wide and once because the exitance is a pixel's mean. All frequencies up to
// `alias_rings` pixel frequencies are summed; the rest changes the lit face by about 1e-6
// relatively and the far one by 1e-7 (measured, tests/forward/analytic/block_test.cpp). No grid
// enters along the light.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "forward/analytic/layered_mode.h"
#include "forward/forward_model.h"

namespace kappamu::forward {

/// κ and μ from the lit face to the one opposite, equal neighbours joined. Throws InputError naming
/// coefficient and voxel where a layer is not uniform.
std::vector<Layer> layers_along_light(const GridSetup& setup, const Medium& medium);

/// Throws InputError, saying why, where sides are open or layers not uniform.
std::unique_ptr<ForwardModel> make_analytic_model();

}  // namespace kappamu::forward
