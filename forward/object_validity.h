// What diffusion itself errs by on an object, as far as that of a slab is known.
#pragma once

#include <memory>

#include "forward/object_model.h"

namespace kappamu::forward {

/// A model of diffusion that warns, in one sentence, where diffusion errs by more than 10 % in a
/// slab of the object's albedo and thickness 2V/S (docs/validity.md).
std::unique_ptr<ObjectModel> warned_of_diffusion(std::unique_ptr<ObjectModel> model);

}  // namespace kappamu::forward
