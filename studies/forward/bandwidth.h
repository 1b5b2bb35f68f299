// What a device's memory delivers: the yardstick of every memory-bound kernel.
#pragma once

#include "device/context.h"

namespace kappamu::studies {

/// Bytes per second, read plus written, of the better of two copy kernels (one that writes through
/// the cache, one past it where the compiler can), over buffers far larger than any cache. Best of
/// several runs; takes a fraction of a second. Throws as Context does.
double measured_copy_bandwidth(device::Context& context);

}  // namespace kappamu::studies
