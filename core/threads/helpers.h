// Threads that stand by to share loops, one per core but the caller's. Starting a thread takes 75
// µs, longer than many a loop of a fit.
#pragma once

#include <functional>

namespace kappamu {

/// Calls work() here and, while that lasts, in up to `most` other threads that are free; returns
/// when all calls have. work() must not throw, and must leave nothing to do when the call here
/// returns: no thread need have come by then. Loops may be nested and may begin in any thread.
void share(int most, const std::function<void()>& work);

}  // namespace kappamu
