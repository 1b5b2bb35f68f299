// Work on long arrays, spread over the cores.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/parallel.h"

namespace kappamu::forward::embedded {

/// Calls work(begin, end) for parts of [0, rows), on all cores where that pays.
template <class Work>
void for_row_ranges(std::size_t rows, const Work& work) {
  constexpr std::size_t range = 4096;
  if (rows <= 2 * range) {
    work(std::size_t{0}, rows);
    return;
  }
  for_rows(static_cast<int>((rows + range - 1) / range), [&](int k) {
    const std::size_t begin = static_cast<std::size_t>(k) * range;
    work(begin, std::min(rows, begin + range));
  });
}

}  // namespace kappamu::forward::embedded
