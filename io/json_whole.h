// Whole numbers out of JSON, where the library's own conversion lets those of another type wrap
// round or, beyond every integer, be anything.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace kappamu::io {

/// Throws the library's type_error, as its conversions do, for all but a whole number that Integer
/// holds.
template <class Integer, class Json>
Integer whole(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto found = value.template get<std::uint64_t>();
    if (std::in_range<Integer>(found)) return static_cast<Integer>(found);
  } else if (value.is_number_integer()) {
    const auto found = value.template get<std::int64_t>();
    if (std::in_range<Integer>(found)) return static_cast<Integer>(found);
  }
  throw Json::type_error::create(302,
                                 "type must be a whole number in range, but is " +
                                     (value.is_number() ? value.dump() : value.type_name()),
                                 &value);
}

template <class Integer, class Json>
std::vector<Integer> whole_numbers(const Json& values) {
  std::vector<Integer> numbers;
  for (const Json& value : values) numbers.push_back(whole<Integer>(value));
  return numbers;
}

}  // namespace kappamu::io
