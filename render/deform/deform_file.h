// Deformations as scenes and recipes of edits have them (docs/scene.md, "deform").
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "io/json_node.h"
#include "render/deform/deformation.h"

namespace kappamu::render {

/// A list. Throws InputError naming field and fix.
std::vector<Deformation> read_deformations(const io::JsonNode& node);

/// As read_deformations() takes it, to the last bit.
nlohmann::ordered_json deformations_json(std::span<const Deformation> deformations);

}  // namespace kappamu::render
