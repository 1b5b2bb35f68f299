#include "forward/linear/opencl/device_rows.h"

#include "forward/linear/opencl/device_lanes.h"

namespace kappamu::forward::linear {

namespace {

/// Where the slices of a pattern begin, and the end of the last.
std::vector<std::uint32_t> slice_starts(const RowPattern& pattern, std::size_t slice) {
  std::vector<std::uint32_t> start{0};
  for (std::size_t row = 0; row < pattern.rows(); row += slice) {
    std::uint32_t longest = 0;
    for (std::size_t i = row; i < std::min(row + slice, pattern.rows()); ++i) {
      longest = std::max(longest, pattern.start[i + 1] - pattern.start[i]);
    }
    start.push_back(start.back() + longest * static_cast<std::uint32_t>(slice));
  }
  return start;
}

/// Of entries [entry][each] their places in slices; what is added is zero.
template <class T>
std::vector<T> sliced(const RowPattern& pattern, const std::vector<T>& values, std::size_t slice) {
  const std::vector<std::uint32_t> start = slice_starts(pattern, slice);
  const std::size_t each = pattern.column.empty() ? 1 : values.size() / pattern.column.size();
  std::vector<T> result(start.back() * each, T{0});
  for_ranges(pattern.rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      std::size_t to = start[row / slice] + row % slice;
      for (std::size_t k = pattern.start[row]; k < pattern.start[row + 1]; ++k, to += slice) {
        std::copy_n(values.data() + k * each, each, result.data() + to * each);
      }
    }
  });
  return result;
}

}  // namespace

DevicePattern::DevicePattern(device::Context& context, const RowPattern& pattern, std::size_t slice)
    : start(uploaded(context, slice_starts(pattern, slice))),
      column(uploaded_values(context, pattern, pattern.column, slice)) {}

template <class T>
device::Buffer uploaded_values(device::Context& context, const RowPattern& pattern,
                               const std::vector<T>& values, std::size_t slice) {
  return slice == 1 ? uploaded(context, values) : uploaded(context, sliced(pattern, values, slice));
}

template device::Buffer uploaded_values(device::Context&, const RowPattern&,
                                        const std::vector<int>&, std::size_t);
template device::Buffer uploaded_values(device::Context&, const RowPattern&,
                                        const std::vector<float>&, std::size_t);
template device::Buffer uploaded_values(device::Context&, const RowPattern&,
                                        const std::vector<double>&, std::size_t);

}  // namespace kappamu::forward::linear
