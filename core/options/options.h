// Options and parameters described once: name, group, unit, bounds and one sentence. Command line,
// JSON, records, fingerprints and documents are visitors of such a description.
//
// A visitor is called with (Option, value); `value` is a bool, int, double, std::uint64_t or
// std::string, in a fit's options (inverse/fit/describe_options.h) an enumerator with its names,
// too.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <variant>

namespace kappamu {

struct Bounds {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();  ///< not allowed itself
  bool closed = false;                                    ///< `least` itself is allowed

  bool hold(double x) const { return (closed ? x >= least : x > least) && x < most; }
};

namespace bounds {
inline constexpr Bounds any{};
inline constexpr Bounds positive{.least = 0.0};
inline constexpr Bounds not_negative{.least = 0.0, .closed = true};
inline constexpr Bounds at_least_one{.least = 1.0, .closed = true};
inline constexpr Bounds below_one{.least = 0.0, .most = 1.0};
inline constexpr Bounds share{.least = 0.0, .most = 1.0, .closed = true};
}  // namespace bounds

/// "must be positive", "must lie in [0, 1)": the end of a sentence; "must be finite" where any
/// number will do.
std::string requirement(const Bounds& bounds);

struct Option {
  const char* name;   ///< the key: in records, scenes and errors
  const char* group;  ///< heading that it is listed below
  const char* flag;   ///< on the command line; "": none of its own
  const char* unit;   ///< "": dimensionless
  Bounds bounds;
  const char* text;            ///< one sentence
  bool shapes_volumes = true;  ///< of a fit: whether the bits of κ and μ depend on it
};

/// A visitor of options whose owner is not known by its type.
using OptionReference = std::variant<bool*, int*, double*, std::uint64_t*, std::string*>;
using OptionVisitor = std::function<void(const Option&, OptionReference)>;

/// Values by name, as files and command lines give them.
using OptionValue = std::variant<bool, double, std::string>;
using OptionValues = std::map<std::string, OptionValue, std::less<>>;

OptionValue value_of(OptionReference reference);
std::string shown_value(const OptionValue& value);

/// Throws InputError that names the option: another kind of value, a number out of bounds or, of a
/// whole number, a broken one.
void set_option(const Option& option, OptionReference reference, const OptionValue& value);

}  // namespace kappamu
