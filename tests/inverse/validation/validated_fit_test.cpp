// A fit validated by a pattern of its own: the score is of volumes that did not see that pattern,
// the volumes handed out are of all patterns, and a kill in either half changes no bit. That they
// are better for it is transport_reference_test.cpp's to show.
#include "inverse/validation/validated_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

struct Case {
  cases::Block block;
  CoefficientPair truth;
  SurfaceMeasurements m;
};

Case structured() {
  Case c;
  c.block.grid = {12, 12, 4, 0.5};
  c.truth = cases::smooth_medium(c.block.grid.refined(2));
  c.m = cases::measure(c.block, c.truth);
  return c;
}

FitOptions volume_options() {
  FitOptions options;
  options.path.model = Model::volume;
  return options;
}

ValidatedFit validated(const SurfaceMeasurements& m, const Checkpoint& first = {},
                       const Checkpoint& second = {}) {
  Progress silent;
  return fit_validated(split_validation(m, std::vector<int>{5}), 0, volume_options(), first, second,
                       silent);
}

TEST(ValidatedFit, TheScoreIsOfVolumesThatDidNotSeeTheValidationPattern) {
  const Case c = structured();
  SurfaceMeasurements brighter = c.m;
  const std::size_t cells = c.m.seen_shape().cells();
  for (std::size_t i = 5 * cells; i < 6 * cells; ++i) brighter.value[i] *= 1.05F;
  const ValidatedFit fit = validated(c.m);
  const ValidatedFit other = validated(brighter);
  ASSERT_TRUE(fit.validated && fit.score && other.validated);
  EXPECT_EQ(fit.validated->mu.values(), other.validated->mu.values());
  EXPECT_NE(fit.fit.medium.mu.values(), other.fit.medium.mu.values());
  EXPECT_GT(other.score->error.E(), 2.0 * fit.score->error.E());
  EXPECT_EQ(fit.fit.report.end, PathEnd::validated) << "of the path, not the weight handed on";
  EXPECT_THAT(fit.fit.report.reason, testing::HasSubstr("cross-validation expects no less error"));
  EXPECT_EQ(fit.fit.prediction.size(), c.m.value.size());
  // What the second half costs is told with the first.
  const SolveCount& last = fit.fit.report.history.back().solves;
  EXPECT_GE(fit.fit.report.solves.total(), last.total());
  for (std::size_t i = 1; i < fit.fit.report.history.size(); ++i) {
    EXPECT_GE(fit.fit.report.history[i].solves.total(),
              fit.fit.report.history[i - 1].solves.total());
  }
}

TEST(ValidatedFit, KilledInEitherHalfItEndsInTheSameBits) {
  const Case c = structured();
  const ValidatedFit whole = validated(c.m);
  // `allowed` saves, then a kill.
  const auto killed = [&](std::vector<std::byte>& saved, int allowed) {
    Checkpoint checkpoint;
    checkpoint.load = cases::once(saved);
    checkpoint.interval_seconds = 0.0;
    checkpoint.save = [&saved, left = allowed](std::span<const std::byte> bytes) mutable {
      saved.assign(bytes.begin(), bytes.end());
      if (--left == 0) throw std::runtime_error("killed");
    };
    return checkpoint;
  };
  std::vector<std::byte> first, second;
  EXPECT_THROW(validated(c.m, killed(first, 7)), std::runtime_error);
  EXPECT_THROW(validated(c.m, killed(first, 1000), killed(second, 3)), std::runtime_error);
  const ValidatedFit resumed = validated(c.m, killed(first, 1000), killed(second, 1000));
  EXPECT_TRUE(resumed.fit.report.resumed);
  EXPECT_EQ(resumed.fit.medium.kappa.values(), whole.fit.medium.kappa.values());
  EXPECT_EQ(resumed.fit.medium.mu.values(), whole.fit.medium.mu.values());
  EXPECT_EQ(resumed.score->error.E(), whole.score->error.E());
}

TEST(ValidatedFit, AHomogeneousBlockStaysAsItWasValidated) {
  Case c = structured();
  const std::size_t cells = c.truth.log_mu.size();
  c.truth = {std::vector<double>(cells, std::log(0.2)), std::vector<double>(cells, std::log(0.01))};
  c.m = cases::measure(c.block, c.truth);
  Progress silent;
  const ValidatedFit fit =
      fit_validated(split_validation(c.m, std::vector<int>{5}), 0, {}, {}, {}, silent);
  EXPECT_EQ(fit.fit.report.model.model, Model::homogeneous);
  EXPECT_FALSE(fit.validated.has_value());
  EXPECT_TRUE(fit.score.has_value());
}

}  // namespace
}  // namespace kappamu::inverse
