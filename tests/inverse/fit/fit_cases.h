// Short names for the tests of the fit: measurements of a made-up block and the score of a volume
// (tests/cases/inverse_case.h).
#pragma once

#include "inverse/fit/fit.h"
#include "tests/cases/inverse_case.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse::cases {

using test_cases::Block;

/// test_cases::measure() of `side`² patches.
inline SurfaceMeasurements measure(const Block& block, const CoefficientPair& fine_fields,
                                   int side = 4) {
  return test_cases::measure(block, fine_fields, side);
}

/// E under 8 × 8 patches.
inline double validation_error(const Block& block, const CoefficientPair& fine_fields,
                               const Medium& medium) {
  return test_cases::appearance_error(medium, test_cases::expose_patches(block, fine_fields, 8));
}

/// Checkpoint::load that gives `newest` once, then nothing.
inline std::function<std::optional<std::vector<std::byte>>()> once(std::vector<std::byte> newest) {
  return [bytes = std::optional(std::move(newest))]() mutable {
    if (bytes && bytes->empty()) bytes.reset();
    return std::exchange(bytes, std::nullopt);
  };
}

inline ChannelFit fit(const SurfaceMeasurements& measurements, const FitOptions& options,
                      const Checkpoint& checkpoint = {}) {
  Progress silent;
  return fit_channel(measurements, 0, options, checkpoint, silent);
}

}  // namespace kappamu::inverse::cases
