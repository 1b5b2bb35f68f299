#include "io/mesh/mesh_claims.h"

#include <string_view>

#include "core/error.h"
#include "io/mesh/file_bytes.h"
#include "io/mesh/ply_claims.h"
#include "io/mesh_file.h"

namespace kappamu::io {

namespace {

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw InputError(name + ": " + what);
}

MeshClaims obj_claims(std::string_view text, const std::string& name) {
  MeshClaims claims;
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string_view line = next_line(text);
    const std::string_view what = next_word(line);
    if (what == "v") ++claims.vertices;
    if (what != "f") continue;
    std::size_t corners = 0;
    while (!next_word(line).empty()) ++corners;
    if (corners > most_polygon_corners) {
      fail(name, "the polygon of line " + std::to_string(number) + " has " +
                     std::to_string(corners) + " corners; at most " +
                     std::to_string(most_polygon_corners) + " are taken, triangulate the mesh");
    }
    claims.triangles += corners < 3 ? 0 : corners - 2;
  }
  return claims;
}

MeshClaims stl_claims(std::span<const std::byte> file, const std::string& name) {
  constexpr std::size_t header = 84, facet = 50;
  const std::string_view text = text_of(file);
  if (file.size() >= header) {
    const std::size_t declared = word_at(file, header - 4);
    if (file.size() == header + facet * declared) return {declared, 3 * declared};
    if (!text.starts_with("solid")) {
      fail(name, "its header declares " + std::to_string(declared) + " triangles, " +
                     std::to_string(header + facet * declared) + " bytes, and the file has " +
                     std::to_string(file.size()) + "; export it again");
    }
  }
  if (!text.starts_with("solid")) fail(name, "is no STL file; export it again");
  MeshClaims claims;
  for (std::string_view rest = text; !rest.empty();) {
    std::string_view line = next_line(rest);
    claims.triangles += next_word(line) == "endfacet" ? 1 : 0;
  }
  claims.vertices = 3 * claims.triangles;
  return claims;
}

}  // namespace

MeshClaims mesh_claims(std::span<const std::byte> file, const std::string& format,
                       const std::string& name) {
  if (format == "obj") return obj_claims(text_of(file), name);
  if (format == "stl") return stl_claims(file, name);
  return ply_claims(text_of(file), name);
}

}  // namespace kappamu::io
