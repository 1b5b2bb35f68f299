// What diffusion itself errs by on an object, as far as that of a slab is known.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "forward/object_model.h"

namespace kappamu::forward {

/// One sentence where diffusion errs by more than 10 % in a slab of the object's albedo and
/// thickness 2V/S (docs/validity.md).
std::optional<std::string> object_validity_warning(const ObjectProblem& problem);

/// A model of diffusion, which then warns of it.
std::unique_ptr<ObjectModel> warned_of_diffusion(std::unique_ptr<ObjectModel> model);

}  // namespace kappamu::forward
