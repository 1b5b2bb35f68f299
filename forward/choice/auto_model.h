// Model `auto`: the cheapest model whose measured error is within the tolerance answers
// (forward/choice/choice.h).
#pragma once

#include <memory>

#include "forward/choice/machine_costs.h"
#include "forward/object_model.h"

namespace kappamu::forward {

inline constexpr const char* auto_model_name = "auto";

/// One model for all channels of an object. The tolerance counts physics and numerics together;
/// `photons` is the most that `montecarlo` may take. A model that refuses the object is passed
/// over. `candidates` of the results say why.
std::unique_ptr<ObjectModel> make_auto_model(const MachineCosts& costs);

}  // namespace kappamu::forward
