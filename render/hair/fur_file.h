// Fur as scenes state it (docs/scene.md), and its changes as recipes do (docs/formats.md).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "io/json_node.h"
#include "render/hair/fur.h"

namespace kappamu::render {

/// Names of images are relative to `folder`. Throws InputError naming field and fix.
Fur read_fur(const io::JsonNode& node, const std::filesystem::path& folder);

/// The field `fur` of an edit. Throws InputError naming field and fix.
FurChange read_fur_change(const io::JsonNode& node);
/// As read_fur_change() takes it, to the last bit.
nlohmann::ordered_json json_of(const FurChange& change);

/// Writes over what `json`, a fur as read_fur() takes it, states: all that changes can change.
void put_changes(const Fur& fur, nlohmann::ordered_json& json);

}  // namespace kappamu::render
