// A JSON object whose every field is known: misspelt, missing and mistyped fields are told by name,
// never silently ignored.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace kappamu::io {

class StrictJson {
 public:
  /// Throws InputError unless `file` holds one object with fields from `known` only, whose "format"
  /// is `format` and whose "version" is 1.
  StrictJson(const std::filesystem::path& file, std::string_view format,
             const std::vector<std::string_view>& known);
  ~StrictJson();

  bool has(const char* name) const;
  // Each throws InputError naming file and field if it is missing or of another type.
  std::string text(const char* name) const;
  double number(const char* name) const;
  const nlohmann::json& array(const char* name) const;
  const nlohmann::json& object(const char* name) const;
  /// [nx, ny, nz], each from 1 to 65536.
  std::array<int, 3> grid(const char* name) const;
  /// One or more different names (core/file_name.h).
  std::vector<std::string> names(const char* name) const;
  /// A string through one of core's readers of names.
  template <class T>
  T named(const char* name, T (*from_string)(const std::string&)) const {
    const std::string value = text(name);
    try {
      return from_string(value);
    } catch (const InputError& error) {
      fail(name, std::string("is wrong: ") + error.what());
    }
  }
  [[noreturn]] void fail(const char* name, const std::string& why) const;

 private:
  const nlohmann::json& field(const char* name) const;

  std::string file_;
  std::unique_ptr<nlohmann::json> json_;
};

}  // namespace kappamu::io
