// Short names for the tests of the fit: measurements of a made-up block and the score of a volume
// (tests/cases/inverse_case.h).
#pragma once

#include <gtest/gtest.h>

#include <cmath>

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

template <class Values>
double rms_log_ratio(const Values& a, const Values& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += std::pow(std::log(a[i] / b[i]), 2);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

/// As two fits from different starts do, whose light differs by less than the data's relative
/// `noise`.
inline void expect_same_answer(const ChannelFit& a, const ChannelFit& b, double noise) {
  EXPECT_LT(rms_log_ratio(a.prediction, b.prediction), noise);
  EXPECT_LT(rms_log_ratio(a.medium.kappa, b.medium.kappa), 0.2);
}

}  // namespace kappamu::inverse::cases
