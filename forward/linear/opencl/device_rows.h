// Row matrices in a device's memory.
#pragma once

#include <vector>

#include "device/context.h"
#include "forward/linear/row_matrix.h"

namespace kappamu::forward::linear {

/// Entries of the pattern in slices of so many rows, as rows.cl has them.
struct DevicePattern {
  device::Buffer start, column;

  DevicePattern() = default;
  DevicePattern(device::Context& context, const RowPattern& pattern, std::size_t slice);
};

/// `values` of a pattern's entries, `media` each, for its DevicePattern.
template <class T>
device::Buffer uploaded_values(device::Context& context, const RowPattern& pattern,
                               const std::vector<T>& values, std::size_t slice);

}  // namespace kappamu::forward::linear
