#include "core/threads/helpers.h"

#include <algorithm>
#include <execution>
#include <thread>
#include <vector>

namespace kappamu {

void share(int most, const std::function<void()>& work) {
  static const int others = static_cast<int>(std::thread::hardware_concurrency()) - 1;
  if (std::min(most, others) <= 0) return work();
  const std::vector<char> calls(static_cast<std::size_t>(std::min(most, others)) + 1);
  std::for_each(std::execution::par, calls.begin(), calls.end(), [&](char) { work(); });
}

}  // namespace kappamu
