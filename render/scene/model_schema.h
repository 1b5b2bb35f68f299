// The part of the scenes' JSON schema that depends on which models there are.
#pragma once

#include <string>

namespace kappamu::render {

/// What a scene's field `model` may be, as JSON Schema: one object for each model in the registry,
/// with its own parameters.
std::string model_schema();

}  // namespace kappamu::render
