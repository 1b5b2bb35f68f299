// An object's fields described once, for writing and for reading by io/json_node.h. A type takes
// part by a function of its own namespace,
//   template <class Fields> void describe(Fields& fields, Camera& camera) {
//     fields("width", camera.width);
//     fields.named("encoding", camera.encoding, encoding_names);
//   }
// which writing leaves the object as it is with and reading fills it by. Values are numbers, texts,
// optional values (the field is missing then), lists of at least one, arrays, maps by name and what
// is described itself.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/file_name.h"
#include "core/names.h"
#include "io/json_node.h"

namespace kappamu::io {

/// A JSON value: an object whose fields are put in one by one, or what written() makes.
class FieldWriter {
 public:
  FieldWriter();
  FieldWriter(FieldWriter&& other) noexcept;
  FieldWriter& operator=(FieldWriter&& other) noexcept;
  ~FieldWriter();

  template <class T>
  void operator()(const char* name, T& value) {
    set(name, written(value));
  }
  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    if (value) (*this)(name, *value);
  }
  /// A text or list whose field is missing where it is empty.
  template <class T>
  void optional(const char* name, T& value) {
    if (!value.empty()) (*this)(name, value);
  }
  template <class Value, std::size_t n>
  void named(const char* name, const Value& value, const Names<Value, n>& names) {
    set(name, FieldWriter(name_of(names, value)));
  }
  /// Settles which other fields there are; missing for the `usual` value.
  template <class Value, std::size_t n>
  void kind(const char* name, const Value& value, const Names<Value, n>& names, Value usual) {
    if (value != usual) named(name, value, names);
  }
  /// An object within, of fields that `describe_inner(fields)` describes.
  void object(const char* name, const auto& describe_inner) {
    FieldWriter inner;
    describe_inner(inner);
    set(name, std::move(inner));
  }
  /// A list of objects, missing where it is empty.
  void objects(const char* name, auto& list, const auto& describe_one) {
    if (list.empty()) return;
    FieldWriter all;
    for (auto& item : list) {
      FieldWriter inner;
      describe_one(inner, item);
      all.append(std::move(inner));
    }
    set(name, std::move(all));
  }
  /// A text that is always the same; `fix` follows what a file has instead.
  void fixed(const char* name, const char* text, const char* /*fix*/) {
    set(name, FieldWriter(std::string(text)));
  }
  /// "format" and "version", which is 1.
  void format(const char* name) {
    set("format", FieldWriter(std::string(name)));
    set("version", FieldWriter(1));
  }

  template <class T>
  static FieldWriter written(T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      return FieldWriter(value);
    } else if constexpr (requires { typename T::mapped_type; }) {
      FieldWriter inner;
      for (auto& [name, item] : value) inner(name.c_str(), item);
      return inner;
    } else if constexpr (requires { value.begin(); }) {
      FieldWriter list;
      for (auto& item : value) list.append(written(item));
      return list;
    } else {
      FieldWriter inner;
      describe(inner, value);
      return inner;
    }
  }

  /// Throws InputError naming `file` where a text is not UTF-8.
  std::string text(const std::filesystem::path& file) const;

 private:
  explicit FieldWriter(int value);
  explicit FieldWriter(double value);
  explicit FieldWriter(std::uint64_t value);
  explicit FieldWriter(const std::string& value);
  void set(const char* name, FieldWriter value);
  void append(FieldWriter value);

  std::unique_ptr<nlohmann::ordered_json> value_;
};

/// The names a description has, so that no other field is there and none is missing.
class FieldNames {
 public:
  explicit FieldNames(const JsonNode& node) : node_(node) {}
  void expect() const { node_.expect_fields(required_, optional_); }

  template <class T>
  void operator()(const char* name, T& /*value*/) {
    required_.emplace_back(name);
  }
  template <class T>
  void operator()(const char* name, std::optional<T>& /*value*/) {
    optional_.emplace_back(name);
  }
  void optional(const char* name, auto& /*value*/) { optional_.emplace_back(name); }
  void named(const char* name, auto& /*value*/, const auto& /*names*/) {
    required_.emplace_back(name);
  }
  template <class Value, std::size_t n>
  void kind(const char* name, Value& value, const Names<Value, n>& names, Value /*usual*/) {
    optional_.emplace_back(name);
    if (node_.has(name)) value = node_[name].named(names);
  }
  void object(const char* name, const auto& /*describe_inner*/) { required_.emplace_back(name); }
  void objects(const char* name, auto& /*list*/, const auto& /*describe_one*/) {
    optional_.emplace_back(name);
  }
  void fixed(const char* name, const char* /*text*/, const char* /*fix*/) {
    required_.emplace_back(name);
  }
  void format(const char* /*name*/) { required_.insert(required_.end(), {"format", "version"}); }

 private:
  JsonNode node_;
  std::vector<std::string_view> required_, optional_;
};

/// Throws InputError naming file and field where the document has another shape.
class FieldReader {
 public:
  explicit FieldReader(const JsonNode& node) : node_(node) {}

  template <class T>
  void operator()(const char* name, T& value) {
    read(node_[name], value);
  }
  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    if (node_.has(name)) read(node_[name], value.emplace());
  }
  void optional(const char* name, auto& value) {
    if (node_.has(name)) read(node_[name], value);
  }
  template <class Value, std::size_t n>
  void named(const char* name, Value& value, const Names<Value, n>& names) {
    value = node_[name].named(names);
  }
  void kind(const char*, const auto&, const auto&, const auto&) {}  // FieldNames has read it
  void object(const char* name, const auto& describe_inner) {
    read_object(node_[name], describe_inner);
  }
  template <class T>
  void objects(const char* name, std::vector<T>& list, const auto& describe_one) {
    if (!node_.has(name)) return;
    for (const JsonNode& item : node_[name].items(1)) {
      T& one = list.emplace_back();
      read_object(item, [&](auto& fields) { describe_one(fields, one); });
    }
  }
  void fixed(const char* name, const std::string& text, const std::string& fix) {
    const std::string found = node_[name].text();
    if (found != text) node_[name].fail("is '" + shown_name(found) + "'; " + fix);
  }
  void format(const char* name) { node_.expect_format(name); }

  template <class T>
  static void read(const JsonNode& node, T& value) {
    if constexpr (std::is_same_v<T, int>) {
      value = node.integer();
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
      value = node.whole();
    } else if constexpr (std::is_same_v<T, double>) {
      value = node.number();
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = node.text();
    } else if constexpr (requires { typename T::mapped_type; }) {
      for (const auto& [name, item] : node.members()) read(item, value[name]);
    } else if constexpr (requires { value.emplace_back(); }) {
      value.clear();
      for (const JsonNode& item : node.items(1)) read(item, value.emplace_back());
    } else if constexpr (requires { value.begin(); }) {
      const std::vector<JsonNode> items = node.exactly(value.size());
      for (std::size_t i = 0; i < value.size(); ++i) read(items[i], value[i]);
    } else {
      read_object(node, [&](auto& fields) { describe(fields, value); });
    }
  }

 private:
  static void read_object(const JsonNode& node, const auto& describe_all) {
    FieldNames names(node);
    describe_all(names);
    names.expect();
    FieldReader reader(node);
    describe_all(reader);
  }

  JsonNode node_;
};

}  // namespace kappamu::io
