// Ctrl-C while a window is open.
#pragma once

#include <csignal>

namespace kappamu::app {

/// Ctrl-C asks the window to end, as long as this lives.
class InterruptWatch {
 public:
  InterruptWatch() {
    signalled_ = 0;
    before_ = std::signal(SIGINT, [](int) { signalled_ = 1; });
  }
  ~InterruptWatch() { std::signal(SIGINT, before_); }
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;
  bool happened() const { return signalled_ != 0; }

 private:
  static inline volatile std::sig_atomic_t signalled_ = 0;
  void (*before_)(int);
};

}  // namespace kappamu::app
