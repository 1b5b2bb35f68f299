// Materials whose coefficients were measured and published.
#pragma once

#include <string>
#include <vector>

#include "render/scene/scene.h"

namespace kappamu::render {

/// "apple", "marble", "whole milk", ...
std::vector<std::string> published_material_names();

/// Throws InputError, listing the names, unless there is one of this name.
HomogeneousMaterial published_material(const std::string& name);

/// κ = 1/(3(σa + σs')), μ = σa.
HomogeneousMaterial homogeneous_material(const Colour& reduced_scattering_per_mm,
                                         const Colour& absorption_per_mm);

}  // namespace kappamu::render
