// What passed between the host and its devices since the process began, of all threads together.
#pragma once

#include <cstddef>

namespace kappamu::device {

struct Traffic {
  std::size_t launches = 0;
  std::size_t waits = 0;  ///< calls that return when the device has done all before them
  double seconds = 0.0;   ///< in these
  std::size_t bytes = 0;  ///< copied or mapped, either way

  Traffic since(const Traffic& before) const {
    return {launches - before.launches, waits - before.waits, seconds - before.seconds,
            bytes - before.bytes};
  }
};

Traffic traffic();

}  // namespace kappamu::device
