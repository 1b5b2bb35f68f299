// What a polygrid's equations and their hierarchy are in the device's memory.
#pragma once

#include <cstdint>
#include <vector>

#include "forward/linear/opencl/device_lanes.h"
#include "forward/polygrid/equations/hierarchy.h"

namespace kappamu::forward::polygrid {

/// A symmetric matrix of which half is stored, [slot][row]: a number of every row, then another of
/// every row, and so on. Numbers for the same distance of column and row lie in the same slot along
/// a line of the lattice, and rows of a line share one list, which names zeros where a row has less
/// than its neighbours.
struct DevicePattern {
  /// Keeps a reference to the pattern.
  DevicePattern(device::Context& context, const Pattern& of);
  std::size_t places() const { return pattern.rows() * slots; }
  /// put(slot, number) for those of `values` that the row has.
  template <class Put>
  void for_numbers(const std::vector<double>& values, int row, const Put& put) const {
    const auto begin = static_cast<std::size_t>(pattern.start[static_cast<std::size_t>(row)]);
    const auto end = static_cast<std::size_t>(pattern.start[static_cast<std::size_t>(row) + 1]);
    for (std::size_t k = begin; k < end; ++k) put(slot_of[k], values[k]);
  }

  const Pattern& pattern;
  int rows = 0;
  std::size_t slots = 0;              ///< numbers of the longest row
  std::vector<std::uint8_t> slot_of;  ///< [number of the pattern]
  device::Buffer list;                ///< [row] where its list lies in `step`
  device::Buffer step;  ///< of each list: its length and 0, then for each column how far it lies
                        ///< from the row and its number from the row's place in slot 0
};

struct DeviceLevel {
  /// `coarser`: rows of the next level; 0: this is the coarsest.
  DeviceLevel(device::Context& context, const GraphLevel& level, std::size_t coarser);

  DevicePattern links;
  device::Buffer first_child, child;  ///< none on the coarsest
};

}  // namespace kappamu::forward::polygrid
