// Works side by side: while one runs on a single core, others fill the rest.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/progress.h"

namespace kappamu {

/// Calls work(index, progress) for every name, at most `at_once` at a time, each in a thread of its
/// own; with one at a time in this one, in order. `progress` passes on to the listener, several
/// works under `stage` and all their names as one, whose share done is their mean, and their
/// warnings in the order of the names, whichever comes first: a work's wait until those before it
/// have ended. Rethrows the first exception; the other works then end with Cancelled at their next
/// update().
void side_by_side(const std::string& stage, const std::vector<std::string>& names, int at_once,
                  Progress& listener,
                  const std::function<void(std::size_t index, Progress& progress)>& work);

}  // namespace kappamu
