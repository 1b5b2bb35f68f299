// What tells one fit from another.
#pragma once

#include <cstdint>
#include <string>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// Of everything that determines the result but program and device: channel, data, options and
/// context.
std::uint64_t fingerprint(const SurfaceMeasurements& measurements, int channel,
                          const FitOptions& options, const FitContext& context);

/// Of what else its bits depend on: the program, as Checkpoint::program has it, and the device with
/// its driver. The number of threads is not among them.
std::uint64_t program_fingerprint(const std::string& program, const Backend& backend);

}  // namespace kappamu::inverse
