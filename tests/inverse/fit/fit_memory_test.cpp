// What a fit needs of main memory is known before it starts.
#include "inverse/fit/fit_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/process_memory.h"
#include "inverse/fit/fit_uncertainty.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using ::testing::HasSubstr;

/// Light of 4 × 4 patches and spots under them, by hand: solving for data would itself take memory.
SurfaceMeasurements spots(const GridShape& grid) {
  SurfaceMeasurements m;
  m.grid = grid;
  m.patterns = 16;
  m.channels = {"G"};
  const double patch = grid.nx / 4.0;
  for (int p = 0; p < m.patterns; ++p) {
    const double cx = (p % 4 + 0.5) * patch;
    const double cy = (p / 4 + 0.5) * patch;
    for (int y = 0; y < grid.ny; ++y) {
      for (int x = 0; x < grid.nx; ++x) {
        const double dx = x + 0.5 - cx;
        const double dy = y + 0.5 - cy;
        const bool lit = std::abs(dx) < patch / 2 && std::abs(dy) < patch / 2;
        m.irradiance.push_back(lit ? 1.0F : 0.0F);
        const double value = 0.05 * std::exp(-std::hypot(dx, dy) / patch);
        m.value.push_back(static_cast<float>(value));
        m.variance.push_back(static_cast<float>(1e-4 * value * value));
      }
    }
  }
  return m;
}

TEST(FitMemory, ThePredictionHoldsThePeak) {
  const double before = peak_memory();
  constexpr double bare = 1e8;  // with its libraries, before any solve
  if (before > bare) GTEST_SKIP() << "other tests ran in this process: the peak may be theirs";
  const SurfaceMeasurements measurements = spots({64, 64, 24, 0.5});
  FitOptions options;
  options.path.model = Model::volume;
  options.path.stage_steps = 14;  // fills the optimiser's memory
  options.path.max_levels = 1;
  // Few weights, far from one another: what one learned the next takes over.
  options.path.first_weight = options.path.last_weight = 1.0;
  options.path.weight_factor = 0.01;
  options.uncertainty.probes = usual_probes;
  const double needed = memory_needed(measurements, options).total();
  const ChannelFit fit = cases::fit(measurements, options);
  estimate_volume_uncertainty(fit, {}, measurements);
  const double used = peak_memory() - before;
  RecordProperty("predicted_over_used", std::to_string(needed / used));
  EXPECT_GT(needed, 0.9 * used);
  EXPECT_LT(needed, 1.3 * used);
}

TEST(FitMemory, TooSmallAMachineIsWarnedOf) {
  const SurfaceMeasurements measurements = spots({256, 256, 20, 0.5});
  const FitMemory memory = memory_needed(measurements, {});
  EXPECT_FALSE(warning_of(memory, 1.01 * memory.total()));
  EXPECT_THAT(warning_of(memory, 1e9).value_or(""),
              HasSubstr("this machine has 1.0 GB; fit a coarser grid or fewer patterns"));
}

}  // namespace
}  // namespace kappamu::inverse
