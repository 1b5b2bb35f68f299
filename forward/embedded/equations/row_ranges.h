// Work on long arrays, spread over the cores.
#pragma once

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
  for_pieces(rows, range,
             [&](std::size_t, std::size_t begin, std::size_t end) { work(begin, end); });
}

}  // namespace kappamu::forward::embedded
