// JSON documents read strictly: a value knows its file and where it stands there, so that every
// message names both; unknown, missing, doubled and mistyped fields are refused.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/names.h"

namespace kappamu::io {

class JsonDocument;

/// Whether every object may have a field "_comment" beside those expected of it.
enum class JsonComments { refused, allowed };

/// Valid as long as its document. Every accessor throws InputError where the value is of another
/// kind.
class JsonNode {
 public:
  [[noreturn]] void fail(const std::string& what) const;

  /// Refuses anything but an object with exactly these fields; those in `optional` may be missing.
  void expect_fields(const std::vector<std::string_view>& required,
                     const std::vector<std::string_view>& optional = {}) const;
  bool has(std::string_view name) const;
  JsonNode operator[](const char* name) const;

  /// Refuses anything but the format `name` in version 1, by the fields "format" and "version".
  void expect_format(const char* name) const;

  /// Of an object: its fields by name.
  std::vector<std::pair<std::string, JsonNode>> members() const;
  std::vector<JsonNode> items(std::size_t at_least) const;
  std::vector<JsonNode> exactly(std::size_t count) const;
  bool is_number() const;

  std::string text() const;
  bool flag() const;
  double number() const;
  double number_between(double smallest, double largest) const;
  int integer() const;
  std::uint64_t whole() const;  ///< not negative, all 64 bits of it
  /// A text out of a fixed list.
  std::string choice(const std::vector<std::string_view>& choices) const;
  /// The same of a list too long for quotes.
  std::string one_of(const std::vector<std::string>& choices) const;
  template <class Value, std::size_t n>
  Value named(const Names<Value, n>& names) const {
    std::vector<std::string_view> choices;
    for (const auto& [name, value] : names) choices.push_back(name);
    return *value_of(names, choice(choices));
  }
  /// A text through one of core's readers of names.
  template <class T>
  T named(T (*from_string)(const std::string&)) const {
    const std::string value = text();
    try {
      return from_string(value);
    } catch (const InputError& error) {
      fail(std::string("is wrong: ") + error.what());
    }
  }
  /// [nx, ny, nz], each from 1 to 65536.
  std::array<int, 3> grid() const;
  /// One or more different names (core/file_name.h).
  std::vector<std::string> names() const;

 private:
  friend class JsonDocument;
  JsonNode(const nlohmann::json& value, std::string path, const JsonDocument& document)
      : value_(&value), path_(std::move(path)), document_(&document) {}
  std::string child_path(std::string_view name) const;
  std::string kind() const;

  const nlohmann::json* value_;
  std::string path_;  ///< "lights[2].position_mm"
  const JsonDocument* document_;
};

class JsonDocument {
 public:
  /// Throws InputError unless `file` holds JSON. `hint` names the page that describes the format.
  JsonDocument(const std::filesystem::path& file, std::string hint,
               JsonComments comments = JsonComments::refused);
  /// Of a text in memory, which messages call `name`.
  static JsonDocument of_text(const std::string& text, std::string name, std::string hint,
                              JsonComments comments = JsonComments::refused);
  ~JsonDocument();
  JsonDocument(const JsonDocument&) = delete;
  JsonDocument& operator=(const JsonDocument&) = delete;

  JsonNode root() const;

 private:
  friend class JsonNode;
  JsonDocument(std::string name, const std::string& text, std::string hint, JsonComments comments);
  std::string file_, hint_;
  JsonComments comments_;
  std::unique_ptr<nlohmann::json> json_;
};

}  // namespace kappamu::io
