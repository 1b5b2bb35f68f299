#include "io/strict_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/json_reason.h"
#include "io/read_file.h"

namespace kappamu::io {

using nlohmann::json;

StrictJson::StrictJson(const std::filesystem::path& file, std::string_view format,
                       const std::vector<std::string_view>& known)
    : file_(file.string()) {
  try {
    json_ = std::make_unique<json>(json::parse(read_text(file)));
  } catch (const json::exception& error) {
    throw InputError(file_ + ": not valid JSON (" + shown_text(json_reason(error)) +
                     "); correct it there.");
  }
  if (!json_->is_object()) throw InputError(file_ + ": must hold one JSON object");
  for (const auto& [name, value] : json_->items()) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw InputError(file_ + ": unknown field '" + shown_name(name) +
                       "'; remove it or correct its name");
    }
  }
  if (text("format") != format) fail("format", "is not \"" + std::string(format) + "\"");
  if (number("version") != 1) fail("version", "must be 1; this program reads no other");
}

StrictJson::~StrictJson() = default;

bool StrictJson::has(const char* name) const {
  return json_->contains(name);
}

std::string StrictJson::text(const char* name) const {
  const json& value = field(name);
  if (!value.is_string()) fail(name, "must be a string");
  return value.get<std::string>();
}

double StrictJson::number(const char* name) const {
  const json& value = field(name);
  if (!value.is_number()) fail(name, "must be a number");
  return value.get<double>();
}

const json& StrictJson::array(const char* name) const {
  const json& value = field(name);
  if (!value.is_array()) fail(name, "must be an array");
  return value;
}

const json& StrictJson::object(const char* name) const {
  const json& value = field(name);
  if (!value.is_object()) fail(name, "must be an object");
  return value;
}

std::array<int, 3> StrictJson::grid(const char* name) const {
  const json& values = array(name);
  std::array<int, 3> extents{};
  constexpr int largest = 1 << 16;
  if (values.size() != extents.size()) fail(name, "must be [nx, ny, nz]");
  for (std::size_t axis = 0; axis < extents.size(); ++axis) {
    const json& extent = values[axis];
    if (!extent.is_number_integer() || extent < 1 || extent > largest) {
      fail(name, "must be three whole numbers from 1 to 65536");
    }
    extents[axis] = extent.get<int>();
  }
  return extents;
}

std::vector<std::string> StrictJson::names(const char* name) const {
  std::vector<std::string> result;
  for (const json& value : array(name)) {
    if (!value.is_string()) fail(name, "must hold names such as \"R\"");
    const auto text = value.get<std::string>();
    require_plain_name(text, file_ + ": a name in field '" + name + "'");
    if (std::find(result.begin(), result.end(), text) != result.end()) {
      fail(name, "names '" + text + "' twice");
    }
    result.push_back(text);
  }
  if (result.empty()) fail(name, "must name at least one");
  return result;
}

void StrictJson::fail(const char* name, const std::string& why) const {
  throw InputError(file_ + ": field '" + name + "' " + why);
}

const json& StrictJson::field(const char* name) const {
  const auto found = json_->find(name);
  if (found == json_->end()) fail(name, "is missing");
  return *found;
}

}  // namespace kappamu::io
