// Polycubes as JSON that a person can write: docs/formats.md, "Polycubes".
#pragma once

#include <filesystem>

#include "core/mesh/polycube.h"

namespace kappamu::io {

/// Throws InputError naming file, field and what is wrong: fields unknown, missing or of another
/// kind, more cells than `most_polycube_cells`, cells that are no valid polycube, corners that no
/// cell has.
Polycube read_polycube(const std::filesystem::path& file);

/// So that read_polycube() gives the same cells, and corners equal to 1e-9 of a cell's edge.
void write_polycube(const Polycube& polycube, const std::filesystem::path& file);

}  // namespace kappamu::io
