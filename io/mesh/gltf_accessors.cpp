#include "io/mesh/gltf_accessors.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/file_name.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

using nlohmann::json;

namespace {

/// "my buffer.bin" of "my%20buffer.bin".
std::string without_escapes(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    const char* digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2) {
      text += static_cast<char>(value);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

/// RFC 4648; nothing where a character is of no meaning.
std::optional<std::vector<std::byte>> from_base64(std::string_view text) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  while (text.ends_with('=')) text.remove_suffix(1);
  std::array<int, 256> value{};
  value.fill(-1);
  for (std::size_t d = 0; d < digits.size(); ++d) {
    value[static_cast<unsigned char>(digits[d])] = static_cast<int>(d);
  }
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const int digit = value[static_cast<unsigned char>(c)];
    if (digit < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> held & 0xFF));
  }
  return bytes;
}

}  // namespace

/// A component: its bytes, and whether it is a float or has a sign.
struct GltfAccessors::Kind {
  std::size_t code = 0, bytes = 0;
  bool is_float = false, is_signed = false;
  bool normalized = false;

  double value(const std::byte* at) const {
    if (is_float) {
      float number = 0;
      std::memcpy(&number, at, sizeof number);
      return number;
    }
    std::uint32_t whole = 0;
    std::memcpy(&whole, at, bytes);  // little endian, as the machine
    const double most =
        static_cast<double>((std::uint64_t{1} << (8 * bytes - (is_signed ? 1 : 0))) - 1);
    double number = whole;
    if (is_signed && number > most) number -= 2.0 * (most + 1.0);
    return normalized ? std::max(number / most, -1.0) : number;
  }
};

void GltfAccessors::refuse(const std::string& what) const {
  builder_.fail(what + "; export it again");
}

const json& GltfAccessors::list(const json& from, const char* field) const {
  static const json none = json::array();
  if (!from.is_object()) refuse("its glTF has a number or list where it should have an object");
  const auto found = from.find(field);
  if (found == from.end()) return none;
  if (!found->is_array()) refuse(std::string(field) + " of its glTF is no list");
  return *found;
}

const json& GltfAccessors::at(const char* field, std::size_t index) const {
  const json& all = list(document_, field);
  if (index >= all.size() || !all[index].is_object()) {
    refuse("its glTF uses number " + std::to_string(index) + " of its " + field +
           ", which it does not have");
  }
  return all[index];
}

std::size_t GltfAccessors::number(const json& from, const char* field,
                                  std::size_t otherwise) const {
  if (!from.is_object()) refuse("its glTF has a number or list where it should have an object");
  const auto found = from.find(field);
  if (found == from.end()) return otherwise;
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() >> 40 != 0) {
    refuse(std::string(field) + " of its glTF is no count");
  }
  return found->get<std::size_t>();
}

std::vector<std::byte> GltfAccessors::buffer_of(const std::string& uri) const {
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(',');
    if (comma == uri.npos || !std::string_view(uri).substr(0, comma).ends_with(";base64")) {
      refuse("a buffer of its glTF is data of another kind than base64");
    }
    auto bytes = from_base64(without_escapes(std::string_view(uri).substr(comma + 1)));
    if (!bytes) refuse("a buffer of its glTF is no base64");
    return std::move(*bytes);
  }
  const std::string relative = without_escapes(uri);
  if (!stays_inside(relative) || relative.find("://") != relative.npos) {
    builder_.fail("takes a buffer from " + MeshBuilder::quoted(relative) +
                  ", which is not beside it; export it with its buffers in the same folder");
  }
  const fs::path file = path_.parent_path() / relative;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    builder_.fail("takes a buffer from " + MeshBuilder::quoted(relative) +
                  ", which is missing; copy it beside the glTF file");
  }
  if (fs::file_size(file, error) > most_mesh_bytes) {
    builder_.fail("takes a buffer from " + MeshBuilder::quoted(relative) + " of more than " +
                  std::to_string(most_mesh_bytes) + " bytes; decimate the mesh");
  }
  return read_bytes(file);
}

std::span<const std::byte> GltfAccessors::buffer(std::size_t index) {
  const json& declared = at("buffers", index);
  const auto uri = declared.find("uri");
  std::span<const std::byte> bytes;
  if (uri == declared.end()) {
    if (!binary_ || index != 0)
      refuse("buffer " + std::to_string(index) + " of its glTF has no uri");
    bytes = *binary_;
  } else {
    if (!uri->is_string()) refuse("a uri of its glTF is no text");
    auto known = buffers_.find(index);
    if (known == buffers_.end()) {
      known = buffers_.emplace(index, buffer_of(uri->get<std::string>())).first;
    }
    bytes = known->second;
  }
  const std::size_t length = number(declared, "byteLength", 0);
  if (length > bytes.size()) {
    refuse("buffer " + std::to_string(index) + " of its glTF is cut short: it has " +
           std::to_string(bytes.size()) + " of " + std::to_string(length) + " bytes");
  }
  return bytes.first(length);
}

/// The bytes of the view that `from` names, from its byteOffset on; `stride` is 0 where the view
/// states none.
std::span<const std::byte> GltfAccessors::view(const json& from, std::size_t& stride) {
  const std::size_t index = number(from, "bufferView", list(document_, "bufferViews").size());
  const json& declared = at("bufferViews", index);
  const std::size_t in_buffer = number(declared, "buffer", list(document_, "buffers").size());
  const std::span<const std::byte> bytes = buffer(in_buffer);
  const std::size_t begin = number(declared, "byteOffset", 0);
  const std::size_t length = number(declared, "byteLength", 0);
  const std::size_t skipped = number(from, "byteOffset", 0);
  if (begin + length > bytes.size()) {
    refuse("bufferView " + std::to_string(index) + " of its glTF reaches beyond buffer " +
           std::to_string(in_buffer));
  }
  if (skipped > length) {
    refuse("an accessor of its glTF reaches beyond bufferView " + std::to_string(index));
  }
  stride = number(declared, "byteStride", 0);
  return bytes.subspan(begin + skipped, length - skipped);
}

std::vector<double> GltfAccessors::stored(const json& from, const Kind& kind, std::size_t parts,
                                          std::size_t count) {
  std::size_t stride = 0;
  const std::span<const std::byte> bytes = view(from, stride);
  const std::size_t size = parts * kind.bytes;
  stride = std::max(stride, size);
  if (count > 0 && stride * (count - 1) + size > bytes.size()) {
    refuse("an accessor of its glTF reaches beyond bufferView " +
           std::to_string(number(from, "bufferView", 0)));
  }
  std::vector<double> values;
  values.reserve(count * parts);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < parts; ++k) {
      values.push_back(kind.value(bytes.data() + i * stride + k * kind.bytes));
    }
  }
  return values;
}

Accessor GltfAccessors::read(std::size_t index, const char* use, std::size_t parts,
                             std::size_t most) {
  constexpr std::array<Kind, 6> kinds{{{5120, 1, false, true},
                                       {5121, 1, false, false},
                                       {5122, 2, false, true},
                                       {5123, 2, false, false},
                                       {5125, 4, false, false},
                                       {5126, 4, true, true}}};
  const json& accessor = at("accessors", index);
  const auto kind_of = [&](const json& from) {
    const std::size_t code = number(from, "componentType", 0);
    const auto* found = std::find_if(kinds.begin(), kinds.end(),
                                     [&](const Kind& kind) { return kind.code == code; });
    const bool of_index = parts == 1 || &from != &accessor;
    if (found == kinds.end() || (of_index && found->is_signed)) {
      refuse(std::string(use) + " of its glTF is of another type than glTF 2.0 asks for");
    }
    return *found;
  };
  Kind kind = kind_of(accessor);
  kind.normalized = accessor.value("normalized", json(false)) == true;
  constexpr std::array<const char*, 3> types{"SCALAR", "VEC2", "VEC3"};
  if (accessor.value("type", json()) != types.at(parts - 1)) {
    refuse(std::string(use) + " of its glTF is of another type than glTF 2.0 asks for");
  }
  Accessor result;
  result.count = number(accessor, "count", 0);
  if (result.count > most) {
    builder_.fail("has " + std::to_string(result.count) + " " + use + " in one accessor; at most " +
                  std::to_string(most) + " are taken, decimate the mesh");
  }
  // Of no view, it is zeros.
  if (accessor.contains("bufferView")) {
    result.values = stored(accessor, kind, parts, result.count);
  } else {
    result.values.resize(result.count * parts);
  }
  if (!accessor.contains("sparse")) return result;
  const json& sparse = accessor["sparse"];
  const std::size_t replaced = number(sparse, "count", 0);
  if (replaced > result.count || !sparse.contains("indices") || !sparse.contains("values")) {
    refuse("accessor " + std::to_string(index) + " of its glTF is sparse without what is replaced");
  }
  const std::vector<double> places =
      stored(sparse["indices"], kind_of(sparse["indices"]), 1, replaced);
  const std::vector<double> values = stored(sparse["values"], kind, parts, replaced);
  for (std::size_t i = 0; i < replaced; ++i) {
    if (!(places[i] < static_cast<double>(result.count))) {
      refuse("accessor " + std::to_string(index) + " of its glTF replaces what it does not have");
    }
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i * parts), parts,
                result.values.begin() +
                    static_cast<std::ptrdiff_t>(static_cast<std::size_t>(places[i]) * parts));
  }
  return result;
}

}  // namespace kappamu::io
