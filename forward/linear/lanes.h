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

/// [number][medium] from number(used lane, k); lanes that are not used have zeros.
template <class Number>
std::vector<float> by_medium(std::size_t count, const Lanes& lanes, const Number& number) {
  const std::size_t media = lanes.media();
  std::vector<float> result(count * media, 0.0F);
  for (std::size_t m = 0; m < lanes.channels.size(); ++m) {
    for (std::size_t k = 0; k < count; ++k) {
      result[k * media + m] = static_cast<float>(number(m, k));
    }
  }
  return result;
}

/// Batches of lights: one light of each medium where that fills lanes, else lights of one medium.
struct Batch {
  Lanes lanes;
  std::vector<std::size_t> lights;  ///< per lane in use
};
std::vector<Batch> batches_of(const std::vector<Load>& loads);

}  // namespace kappamu::forward::linear
