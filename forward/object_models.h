// Models of objects by the names users give them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "forward/model_error.h"

namespace kappamu::forward {

/// Those that make_object_model() knows, in the order they are listed to users.
std::vector<std::string> object_model_names();

/// Throws InputError, listing the names, for another one.
std::unique_ptr<ObjectModel> make_object_model(const std::string& name,
                                               ModelError error = ModelError::warned);

}  // namespace kappamu::forward
