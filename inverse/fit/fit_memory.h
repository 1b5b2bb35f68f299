// The memory that a fit takes at its peak, known before it starts.
#pragma once

#include <optional>
#include <string>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// Memory of one channel's volume on `measurements.grid` [bytes]; simpler models take less.
struct FitMemory {
  double device = 0.0;  ///< main memory too where the device is a processor
  double host = 0.0;
  double total() const { return device + host; }
};

/// Held to the measured peak by a test.
FitMemory memory_needed(const SurfaceMeasurements& measurements, const FitOptions& options);

/// How many of `channels` may be fitted side by side: as many as half the machine's memory holds,
/// and half the device's.
int fits_at_once(const FitMemory& of_one, const Backend& backend, int channels);

/// "about 5.4 GB of memory at the peak".
std::string in_words(const FitMemory& memory);
/// A warning if `available` bytes are too few.
std::optional<std::string> warning_of(const FitMemory& memory, double available);

}  // namespace kappamu::inverse
