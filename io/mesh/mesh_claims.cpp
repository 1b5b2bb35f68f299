#include "io/mesh/mesh_claims.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "io/mesh/file_bytes.h"
#include "io/mesh_file.h"

namespace kappamu::io {

namespace {

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw InputError(name + ": " + what);
}

/// Takes the next line, without its end, off `text`.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

std::string_view next_word(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(" \t\r"), line.size());
  line.remove_prefix(begin);
  const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
  line.remove_prefix(word.size());
  return word;
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

MeshClaims ply_claims(std::string_view text, const std::string& name) {
  const std::size_t size = text.size();
  if (next_line(text).substr(0, 3) != "ply") fail(name, "is no PLY file; export it again");
  MeshClaims claims;
  std::size_t elements = 0;
  std::vector<std::string_view> known;
  constexpr int most_lines = 1000;
  for (int line_number = 0; line_number < most_lines && !text.empty(); ++line_number) {
    std::string_view line = next_line(text);
    const std::string_view what = next_word(line);
    if (what == "end_header") {
      if (elements > size) break;  // of a byte at the least
      return claims;
    }
    if (what != "element") continue;
    const std::string_view element = next_word(line), count = next_word(line);
    std::size_t declared = 0;
    const auto [end, error] = std::from_chars(count.begin(), count.end(), declared);
    if (error != std::errc() || end != count.end() || declared > size) {
      fail(name, "its header declares '" + std::string(count.substr(0, 24)) + "' of element '" +
                     std::string(element.substr(0, 24)) + "', which a file of " +
                     std::to_string(size) + " bytes cannot hold; export it again");
    }
    if (element == "tristrips") {
      fail(name, "its triangles are strips; export it again with faces");
    }
    // Assimp 5.2 makes room for the first of a kind and writes those of a second one behind it.
    if (std::find(known.begin(), known.end(), element) != known.end()) {
      fail(name, "its header declares element '" + std::string(element.substr(0, 24)) +
                     "' twice; export it again");
    }
    known.push_back(element);
    elements += declared;
    if (element == "vertex") claims.vertices = declared;
    if (element == "face") claims.triangles = declared;
  }
  fail(name, "its header has no end, or declares more than the file holds; export it again");
}

}  // namespace

MeshClaims mesh_claims(std::span<const std::byte> file, const std::string& format,
                       const std::string& name) {
  if (format == "obj") return obj_claims(text_of(file), name);
  if (format == "stl") return stl_claims(file, name);
  return ply_claims(text_of(file), name);
}

}  // namespace kappamu::io
