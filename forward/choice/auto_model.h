// Model `auto`: the cheapest model whose measured error is within the tolerance answers
// (forward/choice/choice.h).
#pragma once

#include "forward/registry.h"

namespace kappamu::forward {

/// One model for all channels of an object. The tolerance counts physics and numerics together. A
/// model that refuses the object is passed over. `candidates` of the results say why.
ModelDescription auto_model();

}  // namespace kappamu::forward
