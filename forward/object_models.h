// Models of objects by the names users give them.
#pragma once

#include <memory>
#include <string>

#include "forward/object_model.h"

namespace kappamu::forward {

/// "embedded" or "montecarlo". Throws InputError for another name.
std::unique_ptr<ObjectModel> make_object_model(const std::string& name);

}  // namespace kappamu::forward
