#include "forward/polygrid/opencl/device_numbers.h"

#include <algorithm>
#include <map>
#include <utility>

#include "forward/polygrid/opencl/row_lists.h"

namespace kappamu::forward::polygrid {

using linear::uploaded;

DevicePattern::DevicePattern(device::Context& context, const Pattern& of)
    : pattern(of), rows(static_cast<int>(pattern.rows())) {
  for (std::size_t i = 0; i < pattern.rows(); ++i) {
    slots = std::max(slots, static_cast<std::size_t>(pattern.start[i + 1] - pattern.start[i]));
  }
  slot_of = slots_of_numbers(pattern, slots);
  const auto lists = RowLists(pattern, slot_of, slots).runs();
  std::map<RowLists::List, int> places;
  std::vector<int> of_row, steps;
  for (const auto& [end, entries] : lists) {
    const auto [place, fresh] = places.try_emplace(entries, static_cast<int>(steps.size() / 2));
    if (fresh) {
      steps.insert(steps.end(), {static_cast<int>(entries.size()), 0});
      for (const auto& [distance, number] : entries) {
        steps.insert(steps.end(), {distance, number});
      }
    }
    of_row.resize(static_cast<std::size_t>(end), place->second);
  }
  list = uploaded(context, of_row);
  step = uploaded(context, steps);
}

DeviceLevel::DeviceLevel(device::Context& context, const GraphLevel& level, std::size_t coarser)
    : links(context, level.links) {
  if (coarser == 0) return;
  std::vector<int> first(coarser + 1, 0), children(level.parent.size());
  for (const int p : level.parent) ++first[static_cast<std::size_t>(p) + 1];
  for (std::size_t p = 0; p < coarser; ++p) first[p + 1] += first[p];
  std::vector<int> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < children.size(); ++i) {
    children[static_cast<std::size_t>(next[static_cast<std::size_t>(level.parent[i])]++)] =
        static_cast<int>(i);
  }
  first_child = uploaded(context, first);
  child = uploaded(context, children);
}

}  // namespace kappamu::forward::polygrid
