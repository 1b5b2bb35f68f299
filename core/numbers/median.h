// The median of many values, where the mean of two middle ones is not worth sorting for.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/error.h"

namespace kappamu {

/// The middle value, of an even number the upper of the two; of at least one value.
template <class T>
T upper_median(std::vector<T> values) {
  check(!values.empty(), "upper_median: at least one value");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace kappamu
