#include "io/mesh/mesh_claims.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.h"
#include "io/mesh_file.h"

namespace kappamu::io {

namespace {

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw InputError(name + ": " + what);
}

std::string_view text_of(std::span<const std::byte> file) {
  return {reinterpret_cast<const char*>(file.data()), file.size()};
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

std::uint32_t word_at(std::span<const std::byte> file, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
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
    elements += declared;
    if (element == "vertex") claims.vertices = declared;
    if (element == "face") claims.triangles = declared;
  }
  fail(name, "its header has no end, or declares more than the file holds; export it again");
}

/// The JSON of a .glb file: the first chunk.
std::string_view json_of_glb(std::span<const std::byte> file, const std::string& name) {
  constexpr std::size_t header = 20;
  constexpr std::uint32_t magic = 0x46546C67, json_chunk = 0x4E4F534A;
  if (file.size() < header || word_at(file, 0) != magic || word_at(file, 16) != json_chunk ||
      word_at(file, 8) != file.size() || word_at(file, 12) > file.size() - header) {
    fail(name, "is no binary glTF file of version 2, or is cut short; export it again");
  }
  return text_of(file).substr(header, word_at(file, 12));
}

/// glTF 2.0, sections 5.1 (accessors), 5.10 (buffers), 5.11 (views): every accessor lies in its
/// view, every view in its buffer.
class GltfCheck {
 public:
  GltfCheck(std::string_view text, const std::string& name)
      : name_(name), json_(nlohmann::json::parse(text, nullptr, false)) {
    if (!json_.is_object()) fail(name, "its glTF is not a JSON object; export it again");
    if (!list("extensionsRequired").empty()) {
      fail(name, "needs the glTF extension " + json_["extensionsRequired"][0].dump().substr(0, 60) +
                     "; export it without extensions");
    }
  }

  MeshClaims claims() {
    std::vector<std::size_t> counts;
    for (const auto& accessor : list("accessors")) {
      counts.push_back(number(accessor, "count", 0));
      check_accessor(accessor, counts.back());
    }
    const auto count_of = [&](const nlohmann::json& from, const char* field) -> std::size_t {
      if (!from.is_object() || !from.contains(field)) return 0;
      const std::size_t index = number(from, field, 0);
      if (index >= counts.size()) fail_at("accessor", index);
      return counts[index];
    };
    MeshClaims claims;
    for (const auto& mesh : list("meshes")) {
      if (!mesh.is_object() || !mesh.contains("primitives") || !mesh["primitives"].is_array()) {
        fail(name_, "a mesh of its glTF has no primitives; export it again");
      }
      for (const auto& part : mesh["primitives"]) {
        if (!part.is_object() || !part.contains("attributes")) {
          fail(name_, "a primitive of its glTF has no attributes; export it again");
        }
        const std::size_t vertices = count_of(part["attributes"], "POSITION");
        for (const auto& [attribute, index] : part["attributes"].items()) {
          if (!index.is_number_unsigned() || index.get<std::size_t>() >= counts.size()) {
            fail(name_, "attribute " + attribute.substr(0, 24) +
                            " of its glTF is no accessor; export it again");
          }
        }
        claims.vertices += vertices;
        claims.triangles += (part.contains("indices") ? count_of(part, "indices") : vertices) / 3;
      }
    }
    return claims;
  }

 private:
  const nlohmann::json& list(const char* field) {
    static const nlohmann::json none = nlohmann::json::array();
    if (!json_.contains(field)) return none;
    if (!json_[field].is_array()) {
      fail(name_, std::string(field) + " of its glTF is no list; export it again");
    }
    return json_[field];
  }
  [[noreturn]] void fail_at(const char* what, std::size_t index) const {
    fail(name_, std::string("its glTF uses ") + what + " " + std::to_string(index) +
                    ", which it does not have or which is too short; export it again");
  }
  /// Below 2^40, so that sums of products do not overflow.
  std::size_t number(const nlohmann::json& from, const char* field, std::size_t otherwise) const {
    if (!from.is_object()) fail(name_, "its glTF has a list of the wrong kind; export it again");
    if (!from.contains(field)) return otherwise;
    const nlohmann::json& value = from[field];
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() >> 40 != 0) {
      fail(name_, std::string(field) + " of its glTF is no count; export it again");
    }
    return value.get<std::size_t>();
  }
  void check_accessor(const nlohmann::json& accessor, std::size_t count) {
    constexpr std::array<std::pair<std::string_view, std::size_t>, 7> types{{{"SCALAR", 1},
                                                                             {"VEC2", 2},
                                                                             {"VEC3", 3},
                                                                             {"VEC4", 4},
                                                                             {"MAT2", 4},
                                                                             {"MAT3", 9},
                                                                             {"MAT4", 16}}};
    constexpr std::array<std::pair<std::size_t, std::size_t>, 6> components{
        {{5120, 1}, {5121, 1}, {5122, 2}, {5123, 2}, {5125, 4}, {5126, 4}}};
    const std::string type = accessor.value("type", nlohmann::json()).dump();
    std::size_t size = 0;
    for (const auto& [known, parts] : types) {
      if (type == "\"" + std::string(known) + "\"") size = parts;
    }
    const std::size_t component = number(accessor, "componentType", 0);
    const auto* bytes = std::find_if(components.begin(), components.end(),
                                     [&](const auto& c) { return c.first == component; });
    if (size == 0 || bytes == components.end() || accessor.contains("sparse")) {
      fail(name_, "an accessor of its glTF is sparse or of an unknown type; export it again");
    }
    size *= bytes->second;
    const std::size_t view_index = number(accessor, "bufferView", list("bufferViews").size());
    if (view_index >= list("bufferViews").size()) fail_at("bufferView", view_index);
    const nlohmann::json& view = list("bufferViews")[view_index];
    const std::size_t length = number(view, "byteLength", 0);
    const std::size_t stride = std::max(size, number(view, "byteStride", size));
    if (count > 0 && number(accessor, "byteOffset", 0) + stride * (count - 1) + size > length) {
      fail_at("bufferView", view_index);
    }
    const std::size_t buffer = number(view, "buffer", list("buffers").size());
    if (buffer >= list("buffers").size() ||
        number(view, "byteOffset", 0) + length > number(list("buffers")[buffer], "byteLength", 0)) {
      fail_at("buffer", buffer);
    }
  }

  const std::string& name_;
  nlohmann::json json_;
};

}  // namespace

MeshClaims mesh_claims(std::span<const std::byte> file, const std::string& format,
                       const std::string& name) {
  if (format == "obj") return obj_claims(text_of(file), name);
  if (format == "stl") return stl_claims(file, name);
  if (format == "ply") return ply_claims(text_of(file), name);
  return GltfCheck(format == "glb" ? json_of_glb(file, name) : text_of(file), name).claims();
}

}  // namespace kappamu::io
