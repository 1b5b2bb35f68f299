// Which lights are solved for together as lanes of vectors.
#pragma once

#include <cstddef>
#include <vector>

#include "forward/linear/linear_solver.h"

namespace kappamu::forward::linear {

/// How lights lie in a batch: `width` lanes (1, 2, 4 or 8), which share one medium or have one
/// each.
struct Lanes {
  std::size_t width = 1;
  std::vector<std::size_t> channels;  ///< one for all lanes, or one per lane in use
  bool own() const { return channels.size() > 1; }
  /// Numbers per value that depends on the medium.
  std::size_t media() const { return own() ? width : 1; }
};

/// Batches of lights: one light of each medium where that fills lanes, else lights of one medium.
struct Batch {
  Lanes lanes;
  std::vector<std::size_t> lights;  ///< per lane in use
};
std::vector<Batch> batches_of(const std::vector<Load>& loads);

}  // namespace kappamu::forward::linear
