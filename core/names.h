// Enumerators and the names that the command line, records and documents give them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace kappamu {

template <class Value, std::size_t n>
using Names = std::array<std::pair<const char*, Value>, n>;

/// "" for a value without a name.
template <class Value, std::size_t n>
std::string name_of(const Names<Value, n>& names, Value value) {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return "";
}

/// Nothing for a name of no value.
template <class Value, std::size_t n>
std::optional<Value> value_of(const Names<Value, n>& names, std::string_view name) {
  for (const auto& [known, value] : names) {
    if (name == known) return value;
  }
  return std::nullopt;
}

/// "a, b or c".
template <class Value, std::size_t n>
std::string list_of(const Names<Value, n>& names) {
  std::string list = names.front().first;
  for (std::size_t i = 1; i < n; ++i) {
    list.append(i + 1 < n ? ", " : " or ").append(names[i].first);
  }
  return list;
}

}  // namespace kappamu
