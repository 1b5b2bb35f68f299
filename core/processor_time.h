// Time spent: by the clock, and of the processor.
#pragma once

#include <chrono>
#include <ctime>

namespace kappamu {

/// Of this process, all threads together, since an arbitrary moment [s]: what a measurement can
/// compare on a machine that does other work too.
inline double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

class Stopwatch {
 public:
  /// By the clock, since it was made.
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  double milliseconds() const { return 1e3 * seconds(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace kappamu
