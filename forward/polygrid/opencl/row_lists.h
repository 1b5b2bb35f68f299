// Where rows of a symmetric matrix, half of which is stored, find their numbers, so that rows
// beside each other find them alike.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "forward/polygrid/equations/equations.h"

namespace kappamu::forward::polygrid {

/// [number of the pattern] its slot, less than `slots`: that of the row before for the same
/// distance of the column, else a free one.
std::vector<std::uint8_t> slots_of_numbers(const Pattern& pattern, std::size_t slots);

class RowLists {
 public:
  /// Of every factor: how far its row lies from this one, and how far its number from this row's
  /// place in slot 0.
  using Entry = std::pair<int, int>;
  using List = std::vector<Entry>;  ///< sorted
  struct Run {
    int end = 0;  ///< the row after its last
    List list;
  };

  /// Keeps references.
  RowLists(const Pattern& pattern, const std::vector<std::uint8_t>& slot_of, std::size_t slots);

  /// Of all rows in their order. A run's list has what each of its rows needs; what more it has is
  /// in slots that are empty there.
  std::vector<Run> runs() const;

 private:
  bool empty(int row, const Entry& entry) const;

  int rows_ = 0;
  std::vector<List> of_row_;
  std::vector<char> used_;  ///< [slot][row]
};

}  // namespace kappamu::forward::polygrid
