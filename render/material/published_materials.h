// Materials whose coefficients were measured and published.
#pragma once

#include <string>
#include <vector>

#include "render/material/homogeneous.h"

namespace kappamu::render {

/// "apple", "marble", "whole milk", ...
std::vector<std::string> published_material_names();

/// Throws InputError, listing the names, unless there is one of this name.
HomogeneousMaterial published_material(const std::string& name);

}  // namespace kappamu::render
