#include "io/mesh/gltf_geometry.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/file_name.h"
#include "io/mesh/file_bytes.h"

namespace kappamu::io {

namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw InputError(name + ": " + what + "; export it again");
}

constexpr std::size_t glb_header = 12, chunk_header = 8;

/// The JSON of a .glb file: the first chunk.
std::span<const std::byte> json_chunk(std::span<const std::byte> file, const std::string& name) {
  constexpr std::size_t start = glb_header + chunk_header;
  constexpr std::uint32_t magic = 0x46546C67, json_kind = 0x4E4F534A;
  if (file.size() < start || word_at(file, 0) != magic || word_at(file, 16) != json_kind ||
      word_at(file, 8) != file.size() || word_at(file, 12) > file.size() - start) {
    refuse(name, "is no binary glTF file of version 2, or is cut short");
  }
  return file.subspan(start, word_at(file, 12));
}

void put_little_endian(std::vector<std::byte>& bytes, std::size_t offset, std::size_t value) {
  const auto number = static_cast<std::uint32_t>(value);
  std::memcpy(bytes.data() + offset, &number, sizeof number);
}

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

/// `file` with another JSON before its buffers.
std::vector<std::byte> with_json(std::span<const std::byte> file, std::size_t old_length,
                                 std::string text) {
  text.append((4 - text.size() % 4) % 4, ' ');
  constexpr std::size_t start = glb_header + chunk_header;
  const std::span<const std::byte> rest = file.subspan(start + old_length);
  std::vector<std::byte> result(start + text.size() + rest.size());
  std::copy_n(file.begin(), start, result.begin());
  put_little_endian(result, 8, result.size());
  put_little_endian(result, glb_header, text.size());
  std::memcpy(result.data() + start, text.data(), text.size());
  std::copy(rest.begin(), rest.end(), result.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return result;
}

/// Sections 5.1 (accessors), 5.10 (buffers), 5.11 (views), 5.24 (primitives), 5.25 (nodes).
class Geometry {
 public:
  Geometry(std::string_view text, const std::string& name)
      : name_(name), json_(json::parse(text, nullptr, false)) {
    if (!json_.is_object()) refuse(name, "its glTF is not a JSON object");
    if (const json& extensions = list("extensionsRequired"); !extensions.empty()) {
      const json& first = extensions[0];
      throw InputError(name + ": needs the glTF extension " +
                       (first.is_string() ? "'" + shown_name(first.get<std::string>()) + "'"
                                          : std::string("of no name")) +
                       "; export it without extensions");
    }
  }

  /// The document of what is kept.
  json kept() {
    json result;
    take(json_, "scene", result);
    if (json_.contains("asset") && json_["asset"].is_object()) {
      result["asset"] = json::object();
      take(json_["asset"], "version", result["asset"]);
    }
    keep_each("scenes", {"nodes"}, result);
    keep_each("nodes", {"mesh", "children", "matrix", "rotation", "scale", "translation"}, result);
    keep_each("bufferViews", {"buffer", "byteOffset", "byteLength", "byteStride"}, result);
    keep_each("buffers", {"uri", "byteLength"}, result);
    keep_each("accessors", {"bufferView", "byteOffset", "componentType", "count", "type"}, result);
    for (const json& accessor : list("accessors")) check_accessor(accessor);
    for (const json& mesh : list("meshes")) {
      if (!mesh.is_object() || !mesh.contains("primitives") || !mesh["primitives"].is_array()) {
        refuse(name_, "a mesh of its glTF has no primitives");
      }
      json primitives = json::array();
      for (const json& part : mesh["primitives"]) primitives.push_back(primitive(part));
      result["meshes"].push_back({{"primitives", primitives}});
    }
    return result;
  }

  MeshClaims claims;

 private:
  /// Numbers, texts and lists of numbers: a library descends into what is nested.
  void take(const json& from, const char* field, json& to) const {
    if (!from.contains(field)) return;
    const json& value = from[field];
    const bool flat = value.is_array() ? std::all_of(value.begin(), value.end(),
                                                     [](const json& v) { return v.is_number(); })
                                       : value.is_number() || value.is_string();
    if (!flat)
      refuse(name_, std::string(field) + " of its glTF is neither a number nor a list of them");
    to[field] = value;
  }
  void keep_each(const char* field, std::initializer_list<const char*> parts, json& result) const {
    for (const json& one : list(field)) {
      if (!one.is_object())
        refuse(name_, std::string("a part of the ") + field + " of its glTF is no object");
      json reduced = json::object();
      for (const char* part : parts) take(one, part, reduced);
      result[field].push_back(std::move(reduced));
    }
  }

  json primitive(const json& part) {
    if (!part.is_object() || !part.contains("attributes") || !part["attributes"].is_object()) {
      refuse(name_, "a primitive of its glTF has no attributes");
    }
    const std::size_t vertices = corners(part["attributes"], "POSITION", "VEC3", {5126});
    const bool indexed = part.contains("indices");
    const std::size_t count =
        indexed ? corners(part, "indices", "SCALAR", {5121, 5123, 5125}) : vertices;
    const std::size_t mode = number(part, "mode", triangle_list);
    if (mode > 6 || (mode >= triangle_list && count < 3)) {
      refuse(name_,
             "a primitive of its glTF is of no known mode, or has fewer corners than a triangle");
    }
    claims.vertices += vertices;
    claims.triangles += mode == triangle_list ? count / 3 : count - std::min<std::size_t>(count, 2);
    json result = {{"attributes", {{"POSITION", part["attributes"]["POSITION"]}}}, {"mode", mode}};
    if (indexed) result["indices"] = part["indices"];
    return result;
  }
  /// How many the accessor holds that `field` names, which is of these kinds.
  std::size_t corners(const json& from, const char* field, const char* type,
                      std::initializer_list<std::size_t> components) const {
    const std::size_t index = number(from, field, list("accessors").size());
    if (index >= list("accessors").size()) fail_at("accessor", index);
    const json& accessor = list("accessors")[index];
    if (accessor["type"] != type ||
        std::find(components.begin(), components.end(), number(accessor, "componentType", 0)) ==
            components.end()) {
      refuse(name_, std::string(field) + " of its glTF is of another type than glTF 2.0 asks for");
    }
    return number(accessor, "count", 0);
  }
  const json& list(const char* field) const {
    static const json none = json::array();
    if (!json_.contains(field)) return none;
    if (!json_[field].is_array()) refuse(name_, std::string(field) + " of its glTF is no list");
    return json_[field];
  }
  [[noreturn]] void fail_at(const char* what, std::size_t index) const {
    refuse(name_, std::string("its glTF uses ") + what + " " + std::to_string(index) +
                      ", which it does not have or which is too short");
  }
  /// Below 2^40, so that sums of products do not overflow.
  std::size_t number(const json& from, const char* field, std::size_t otherwise) const {
    if (!from.is_object()) refuse(name_, "its glTF has a list of the wrong kind");
    if (!from.contains(field)) return otherwise;
    const json& value = from[field];
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() >> 40 != 0) {
      refuse(name_, std::string(field) + " of its glTF is no count");
    }
    return value.get<std::size_t>();
  }
  void check_accessor(const json& accessor) const {
    constexpr std::array<std::pair<std::string_view, std::size_t>, 7> types{{{"SCALAR", 1},
                                                                             {"VEC2", 2},
                                                                             {"VEC3", 3},
                                                                             {"VEC4", 4},
                                                                             {"MAT2", 4},
                                                                             {"MAT3", 9},
                                                                             {"MAT4", 16}}};
    constexpr std::array<std::pair<std::size_t, std::size_t>, 6> components{
        {{5120, 1}, {5121, 1}, {5122, 2}, {5123, 2}, {5125, 4}, {5126, 4}}};
    const std::string type = accessor.value("type", json()).dump();
    std::size_t size = 0;
    for (const auto& [known, parts] : types) {
      if (type == "\"" + std::string(known) + "\"") size = parts;
    }
    const std::size_t component = number(accessor, "componentType", 0);
    const auto* bytes = std::find_if(components.begin(), components.end(),
                                     [&](const auto& c) { return c.first == component; });
    if (size == 0 || bytes == components.end() || accessor.contains("sparse")) {
      refuse(name_, "an accessor of its glTF is sparse or of an unknown type");
    }
    size *= bytes->second;
    const std::size_t view_index = number(accessor, "bufferView", list("bufferViews").size());
    if (view_index >= list("bufferViews").size()) fail_at("bufferView", view_index);
    const json& view = list("bufferViews")[view_index];
    const std::size_t length = number(view, "byteLength", 0);
    const std::size_t stride = std::max(size, number(view, "byteStride", size));
    const std::size_t count = number(accessor, "count", 0);
    if (count > 0 && number(accessor, "byteOffset", 0) + stride * (count - 1) + size > length) {
      fail_at("bufferView", view_index);
    }
    const std::size_t buffer = number(view, "buffer", list("buffers").size());
    if (buffer >= list("buffers").size() ||
        number(view, "byteOffset", 0) + length > number(list("buffers")[buffer], "byteLength", 0)) {
      fail_at("buffer", buffer);
    }
  }

  static constexpr std::size_t triangle_list = 4;

  const std::string& name_;
  json json_;
};

}  // namespace

GltfGeometry gltf_geometry(const std::vector<std::byte>& file, const std::string& format,
                           const std::string& name) {
  const bool binary = format == "glb";
  const std::span<const std::byte> text = binary ? json_chunk(file, name) : std::span(file);
  Geometry geometry(text_of(text), name);
  const std::string kept = geometry.kept().dump(-1, ' ', false, json::error_handler_t::replace);
  return {geometry.claims, binary ? with_json(file, text.size(), kept) : bytes_of(kept)};
}

}  // namespace kappamu::io
