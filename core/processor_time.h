// Processor time of this process, all threads together: what a measurement can compare on a machine
// that does other work too.
#pragma once

#include <ctime>

namespace kappamu {

/// Since an arbitrary moment [s].
inline double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

}  // namespace kappamu
