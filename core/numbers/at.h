#pragma once

#include <cstddef>

namespace kappamu {

/// An index of a container from a signed number known not to be negative.
constexpr std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}

}  // namespace kappamu
