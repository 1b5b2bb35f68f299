// Models of objects by the names users give them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "forward/object_model.h"

namespace kappamu::forward {

/// Those that make_object_model() knows, in the order they are listed to users.
std::vector<std::string> object_model_names();

/// Whether models of diffusion warn where diffusion itself errs (object_validity.h).
enum class DiffusionWarning { given, left_out };

/// Throws InputError, listing the names, for another one.
std::unique_ptr<ObjectModel> make_object_model(const std::string& name,
                                               DiffusionWarning warning = DiffusionWarning::given);

}  // namespace kappamu::forward
