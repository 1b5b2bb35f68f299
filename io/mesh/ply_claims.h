// What a PLY file declares, and whether its body holds just that.
#pragma once

#include <string>
#include <string_view>

#include "io/mesh/mesh_claims.h"

namespace kappamu::io {

/// Walks through the whole body, binary or ASCII, of which each line is one of an element, as the
/// header says. Throws InputError, which `name` begins, where it says something unknown, a list is
/// longer than a polygon may be, or the file or a line ends early or late: assimp 5.2 makes room
/// for any length that it reads, wherever it stands.
MeshClaims ply_claims(std::string_view text, const std::string& name);

}  // namespace kappamu::io
