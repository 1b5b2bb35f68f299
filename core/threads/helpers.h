// Loops shared between threads, by the standard library's parallel algorithms (oneTBB beneath).
#pragma once

#include <functional>

namespace kappamu {

/// Calls work() here and, while that lasts, in up to `most` other threads that are free; returns
/// when all calls have. work() must not throw, and must leave nothing to do when a call returns:
/// no other thread need have come by then. Loops may be nested and may begin in any thread.
void share(int most, const std::function<void()>& work);

}  // namespace kappamu
