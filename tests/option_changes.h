// Every described option changed, one at a time: what tests of describe()'s visitors walk along.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/names.h"
#include "inverse/fit/describe_options.h"

namespace kappamu::inverse {

/// Changes the value of option number `wanted`, within its bounds.
struct ChangeOption {
  std::size_t wanted = 0;
  std::size_t at = 0;
  std::optional<Option> changed{};  ///< empty where there are fewer options

  template <class Value>
  void operator()(const Option& option, Value& value) {
    if (take(option)) change(value);
  }
  template <class Value, std::size_t n>
  void operator()(const Option& option, Value& value, const Names<Value, n>& names) {
    if (take(option)) value = names[0].second == value ? names[1].second : names[0].second;
  }

 private:
  bool take(const Option& option) {
    if (at++ != wanted) return false;
    changed = option;
    return true;
  }
  static void change(double& x) { x = 0.25 * x + 0.125; }
  template <class Whole>
  static void change(Whole& n) {
    n += 1;
  }
  static void change(bool& on) { on = !on; }
  static void change(std::string& text) { text += "x"; }
  static void change(std::vector<std::string>& list) { list.emplace_back("G"); }
  static void change(std::optional<double>& x) { x = 0.5; }
};

}  // namespace kappamu::inverse
