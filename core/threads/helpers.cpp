#include "core/threads/helpers.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace kappamu {

namespace {

/// A loop under way, on its caller's stack.
struct Loop {
  Loop(int most, const std::function<void()>& what) : places(most), work(what) {}

  int places;  ///< helpers that may still join
  const std::function<void()>& work;
  int helping = 0;
  std::condition_variable left;
};

class Helpers {
 public:
  Helpers() {
    const std::size_t count = std::max(1U, std::thread::hardware_concurrency()) - 1;
    threads_.reserve(count);
    loops_.reserve(64);
    try {
      while (threads_.size() < count) threads_.emplace_back([this] { stand_by(); });
    } catch (const std::exception&) {
      // No more threads to be had: loops take longer.
    }
  }
  ~Helpers() {
    {
      const std::lock_guard guard(lock_);
      ending_ = true;
    }
    wanted_.notify_all();
  }

  void share(int most, const std::function<void()>& work) {
    Loop loop(std::min(most, static_cast<int>(threads_.size())), work);
    if (loop.places <= 0) return work();
    const bool one = loop.places == 1;
    {
      const std::lock_guard guard(lock_);
      loops_.push_back(&loop);
    }
    one ? wanted_.notify_one() : wanted_.notify_all();
    work();
    std::unique_lock guard(lock_);
    std::erase(loops_, &loop);
    loop.left.wait(guard, [&] { return loop.helping == 0; });
  }

 private:
  /// The newest loop first: it may lie within an older one.
  void stand_by() {
    std::unique_lock guard(lock_);
    while (true) {
      wanted_.wait(guard, [&] { return ending_ || !loops_.empty(); });
      if (ending_) return;
      Loop& loop = *loops_.back();
      ++loop.helping;
      if (--loop.places == 0) std::erase(loops_, &loop);
      guard.unlock();
      loop.work();
      guard.lock();
      std::erase(loops_, &loop);
      if (--loop.helping == 0) loop.left.notify_one();
    }
  }

  std::mutex lock_;
  std::condition_variable wanted_;
  bool ending_ = false;
  std::vector<Loop*> loops_;  ///< that more helpers may join
  std::vector<std::jthread> threads_;
};

Helpers& helpers() {
  static Helpers all;
  return all;
}

}  // namespace

void share(int most, const std::function<void()>& work) {
  helpers().share(most, work);
}

}  // namespace kappamu
