// Method `auto` of blocks: grid diffusion where its measured error is within the tolerance, random
// walks where it is not (forward/choice/choice.h).
#pragma once

#include <memory>

#include "forward/choice/object_features.h"
#include "forward/forward_model.h"

namespace kappamu::forward {

/// Of a block as the laws of objects know it. Behind mirror sides it is a slab without edges.
ObjectFeatures features_of(const GridSetup& setup, const Medium& medium);

/// `model_tolerance` of the options counts physics; `photons` is the most that random walks may
/// take. The result's message begins with the model taken and why. Refuses the convention of [W],
/// whose maps hold another quantity than transport's.
std::unique_ptr<ForwardModel> make_auto_block_model();

}  // namespace kappamu::forward
