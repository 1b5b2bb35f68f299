#include "core/options/options.h"

#include <cmath>
#include <type_traits>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu {

namespace {

template <class Value>
constexpr bool is_number = std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>;

template <class Value>
void set(const Option& option, Value& value, const OptionValue& given) {
  using Given = std::conditional_t<is_number<Value>, double, Value>;
  constexpr const char* kind = is_number<Value>              ? "a number"
                               : std::is_same_v<Value, bool> ? "true or false"
                                                             : "a text";
  const std::string name = option.name;
  const Given* const wanted = std::get_if<Given>(&given);
  if (wanted == nullptr) throw InputError(name + " must be " + kind);
  if constexpr (is_number<Value>) {
    if (!option.bounds.hold(*wanted)) throw InputError(name + " " + requirement(option.bounds));
    if (std::is_integral_v<Value> && *wanted != std::floor(*wanted))
      throw InputError(name + " must be a whole number");
  }
  value = static_cast<Value>(*wanted);
}

}  // namespace

std::string requirement(const Bounds& bounds) {
  const auto number = [](double x) { return formatted("%.10g", x); };
  if (std::isfinite(bounds.most)) {
    return "must lie in " + std::string(bounds.closed ? "[" : "(") + number(bounds.least) + ", " +
           number(bounds.most) + ")";
  }
  if (bounds.closed && bounds.least > 0.0) return "must be at least " + number(bounds.least);
  if (bounds.closed) return "must not be negative";
  return std::isfinite(bounds.least) ? "must be positive" : "must be finite";
}

OptionValue value_of(OptionReference reference) {
  return std::visit(
      [](const auto* value) -> OptionValue {
        if constexpr (is_number<std::decay_t<decltype(*value)>>) {
          return static_cast<double>(*value);
        } else {
          return *value;
        }
      },
      reference);
}

std::string shown_value(const OptionValue& value) {
  if (const bool* on = std::get_if<bool>(&value)) return *on ? "true" : "false";
  if (const double* number = std::get_if<double>(&value)) return formatted("%.10g", *number);
  return std::get<std::string>(value);
}

void set_option(const Option& option, OptionReference reference, const OptionValue& value) {
  std::visit([&](auto* target) { set(option, *target, value); }, reference);
}

}  // namespace kappamu
