#include "forward/polygrid/opencl/row_lists.h"

#include <algorithm>
#include <iterator>

namespace kappamu::forward::polygrid {

namespace {

/// Entries that a run's list may have more than the longest of its rows': each takes a product in
/// all of them.
constexpr std::size_t most_more = 4;

}  // namespace

std::vector<std::uint8_t> slots_of_numbers(const Pattern& pattern, std::size_t slots) {
  std::vector<std::uint8_t> slot_of(pattern.column.size());
  std::vector<char> taken(slots);
  std::vector<std::size_t> left;
  std::size_t before = 0;  // begin of the last row's
  for (std::size_t i = 0; i < pattern.rows(); ++i) {
    const auto begin = static_cast<std::size_t>(pattern.start[i]);
    const auto end = static_cast<std::size_t>(pattern.start[i + 1]);
    std::fill(taken.begin(), taken.end(), 0);
    left.clear();
    for (std::size_t k = begin, last = before; k < end; ++k) {
      // Columns of the last row that are a row less.
      while (last < begin && pattern.column[last] + 1 < pattern.column[k]) ++last;
      if (last < begin && pattern.column[last] + 1 == pattern.column[k]) {
        slot_of[k] = slot_of[last];
        taken[slot_of[k]] = 1;
      } else {
        left.push_back(k);
      }
    }
    std::size_t free = 0;
    for (const std::size_t k : left) {
      while (taken[free] != 0) ++free;
      slot_of[k] = static_cast<std::uint8_t>(free);
      taken[free] = 1;
    }
    before = begin;
  }
  return slot_of;
}

RowLists::RowLists(const Pattern& pattern, const std::vector<std::uint8_t>& slot_of,
                   std::size_t slots)
    : rows_(static_cast<int>(pattern.rows())),
      of_row_(pattern.rows()),
      used_(pattern.rows() * slots, 0) {
  for (int i = 0; i < rows_; ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (int k = pattern.start[row]; k < pattern.start[row + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const int j = pattern.column[at], first = slot_of[at] * rows_;
      used_[static_cast<std::size_t>(first + i)] = 1;
      of_row_[row].emplace_back(j - i, first);
      if (j != i) of_row_[static_cast<std::size_t>(j)].emplace_back(i - j, first + i - j);
    }
  }
  for (List& list : of_row_) std::sort(list.begin(), list.end());
}

bool RowLists::empty(int row, const Entry& entry) const {
  const int factor = row + entry.first;
  return factor >= 0 && factor < rows_ && used_[static_cast<std::size_t>(row + entry.second)] == 0;
}

std::vector<RowLists::Run> RowLists::runs() const {
  std::vector<Run> result;
  List both, more;
  int begin = 0;  // of the last run
  for (int i = 0; i < rows_; ++i) {
    const List& mine = of_row_[static_cast<std::size_t>(i)];
    // Whether what `both` has more than a row's own is empty in all of [first, end).
    const auto adds_nothing = [&](const List& own, int first, int end) {
      more.clear();
      std::set_difference(both.begin(), both.end(), own.begin(), own.end(),
                          std::back_inserter(more));
      for (const Entry& entry : more) {
        for (int row = first; row < end; ++row) {
          if (!empty(row, entry)) return false;
        }
      }
      return true;
    };
    if (!result.empty()) {
      Run& run = result.back();
      both.clear();
      std::set_union(run.list.begin(), run.list.end(), mine.begin(), mine.end(),
                     std::back_inserter(both));
      if (both.size() <= std::max(run.list.size(), mine.size()) + most_more &&
          adds_nothing(mine, i, i + 1) && adds_nothing(run.list, begin, i)) {
        run = {i + 1, both};
        continue;
      }
    }
    begin = i;
    result.push_back({i + 1, mine});
  }
  return result;
}

}  // namespace kappamu::forward::polygrid
