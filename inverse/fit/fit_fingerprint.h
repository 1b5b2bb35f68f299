// A hash that identifies a fit.
#pragma once

#include <cstdint>
#include <string>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// Of everything that determines the result but the device: channel, data, options, context and
/// `program`, as Checkpoint::program has it.
std::uint64_t fingerprint(const SurfaceMeasurements& measurements, int channel,
                          const FitOptions& options, const FitContext& context,
                          const std::string& program = {});

}  // namespace kappamu::inverse
