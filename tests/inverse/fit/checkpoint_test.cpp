// What a killed fit goes on from: to the same bits and the same account of itself; and from nothing
// that is damaged, of another fit or made up.
#include "inverse/checkpoint/checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "core/error.h"
#include "inverse/fit/fit_fingerprint.h"
#include "inverse/fit/fit_run.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using Bytes = std::vector<std::byte>;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Thrown instead of a SIGKILL.
struct Killed {};

/// Warnings in the order in which they are told.
struct Listener : Progress {
  void warn(const std::string& sentence) override { told.push_back(sentence); }
  std::vector<std::string> told;
};

struct Case {
  SurfaceMeasurements m;
  FitOptions options;
};

/// A structured block whose data are brighter than their light explains, which a fit warns of.
Case bright_block(const GridShape& grid, double noise = 0.01) {
  test_cases::Block block;
  block.grid = grid;
  block.noise = noise;
  Case c{cases::measure(block, cases::smooth_medium(grid.refined(2)), 2), {}};
  for (float& value : c.m.value) value *= 1.3F;
  c.options.path.model = Model::volume;
  c.options.path.stage_steps = 3;
  c.options.solver.backend.device = "reference";
  return c;
}

ChannelFit fit(const Case& c, const Checkpoint& checkpoint = {}) {
  return cases::fit(c.m, c.options, checkpoint);
}

std::uint64_t origin_of(const Case& c) {
  return fingerprint(c.m, 0, c.options, {}, "");
}

/// Every checkpoint of a fit, in order.
std::vector<Bytes> all_checkpoints(const Case& c) {
  std::vector<Bytes> saved;
  Checkpoint checkpoint;
  checkpoint.interval_seconds = 0.0;
  checkpoint.save = [&](std::span<const std::byte> bytes) {
    saved.emplace_back(bytes.begin(), bytes.end());
  };
  fit(c, checkpoint);
  return saved;
}

Checkpoint from(const Bytes& bytes) {
  Checkpoint checkpoint;
  checkpoint.load = cases::once(bytes);
  return checkpoint;
}

/// A fit that nothing interrupts, and what it tells on the way.
struct Uninterrupted {
  explicit Uninterrupted(const Case& c) : fit(fit_channel(c.m, 0, c.options, {}, listener)) {}
  Listener listener;
  ChannelFit fit;
};

/// Killed after every fifth save and started again until it ends.
void expect_kills_change_nothing(const Case& c, const Uninterrupted& undisturbed) {
  const ChannelFit& whole = undisturbed.fit;
  Bytes saved;
  int kills = 0;
  Listener last;
  ChannelFit resumed;
  for (bool finished = false; !finished;) {
    Checkpoint checkpoint = from(saved);
    checkpoint.interval_seconds = 0.0;  // after every step
    checkpoint.save = [&, saves = 0](std::span<const std::byte> bytes) mutable {
      saved.assign(bytes.begin(), bytes.end());
      if (++saves == 5) throw Killed{};
    };
    try {
      last = {};
      resumed = fit_channel(c.m, 0, c.options, checkpoint, last);
      finished = true;
    } catch (const Killed&) {
      ++kills;
    }
  }
  EXPECT_GT(kills, 2);
  EXPECT_TRUE(resumed.report.resumed);
  EXPECT_EQ(whole.medium.kappa.values(), resumed.medium.kappa.values());
  EXPECT_EQ(whole.medium.mu.values(), resumed.medium.mu.values());
  EXPECT_EQ(whole.prediction, resumed.prediction);
  EXPECT_EQ(whole.report.weight, resumed.report.weight);
  EXPECT_EQ(whole.report.chi2_per_value, resumed.report.chi2_per_value);
  EXPECT_EQ(whole.report.reason, resumed.report.reason);
  EXPECT_EQ(whole.report.warnings, resumed.report.warnings);
  EXPECT_EQ(undisturbed.listener.told, last.told)
      << "whoever listens hears what he would have heard";
  ASSERT_EQ(whole.report.history.size(), resumed.report.history.size());
  for (std::size_t i = 0; i < whole.report.history.size(); ++i) {
    const SolveCount& a = whole.report.history[i].solves;
    const SolveCount& b = resumed.report.history[i].solves;
    EXPECT_EQ(whole.report.history[i].weight, resumed.report.history[i].weight) << "record " << i;
    EXPECT_EQ(whole.report.history[i].objective, resumed.report.history[i].objective);
    EXPECT_EQ(a.forward, b.forward) << "record " << i;
    EXPECT_EQ(a.adjoint, b.adjoint) << "record " << i;
    EXPECT_EQ(a.refined, b.refined) << "record " << i;
    EXPECT_EQ(a.voxel_iterations, b.voxel_iterations) << "record " << i;
  }
  EXPECT_EQ(whole.report.solves.total(), resumed.report.solves.total());
}

TEST(Checkpoint, KilledAnywhereTheFitEndsInTheSameBitsCountsAndWarnings) {
  Case c = bright_block({10, 8, 8, 0.5});
  c.options.path.stage_steps = 5;
  const Uninterrupted whole(c);
  ASSERT_FALSE(whole.listener.told.empty());
  expect_kills_change_nothing(c, whole);
}

Case photographs(const GridShape& grid) {
  Case c = bright_block(grid, 0.001);
  for (float& value : c.m.value) value /= 1.3F;
  c.m.smooth_error = {1e-4, 1e-4};
  return c;
}

TEST(Checkpoint, KilledOnAGridFittedCloserTheFitEndsInTheSameBits) {
  const Case c = photographs({16, 16, 16, 0.5});
  const Uninterrupted whole(c);
  int begun = 0;
  for (const StepRecord& r : whole.fit.report.history) begun += r.level == 1 && r.step == 0;
  EXPECT_GT(begun, 1);
  expect_kills_change_nothing(c, whole);
}

TEST(Checkpoint, KilledWhereACorrectionIsRenewedTheFitEndsInTheSameBits) {
  Case c = photographs({10, 8, 8, 0.5});
  c.options.path.stage_steps = 80;
  c.options.path.weight = 1000.0;
  const Uninterrupted whole(c);
  const std::vector<StepRecord>& history = whole.fit.report.history;
  bool renewed = false;
  for (std::size_t i = 1; i < history.size(); ++i) {
    const StepRecord &r = history[i], &before = history[i - 1];
    renewed = renewed || (r.level == 0 && r.step > 0 && r.solves.refined > before.solves.refined);
  }
  EXPECT_TRUE(renewed);
  expect_kills_change_nothing(c, whole);
}

TEST(Checkpoint, KilledWithItsVectorsOnADeviceTheFitEndsInTheSameBits) {
  Case c = photographs({10, 8, 8, 0.5});
  c.options.path.stage_steps = 20;
  c.options.solver.backend.device = "auto";
  c.options.solver.backend.vectors = VectorPlace::device;
  expect_kills_change_nothing(c, Uninterrupted(c));
}

TEST(Checkpoint, OfOtherDataOrProgramIsPassedOverAloud) {
  Case c = bright_block({8, 8, 4, 0.5});
  const Bytes bytes = all_checkpoints(c).back();
  EXPECT_TRUE(fit(c, from(bytes)).report.resumed);

  Checkpoint of_other_program = from(bytes);
  of_other_program.program = "another";
  const FitReport program = fit(c, of_other_program).report;
  EXPECT_FALSE(program.resumed);
  EXPECT_THAT(program.warnings, Contains(HasSubstr("another program")));

  c.m.value[0] *= 1.01F;
  const FitReport data = fit(c, from(bytes)).report;
  EXPECT_FALSE(data.resumed);
  EXPECT_THAT(data.warnings,
              Contains("A checkpoint belongs to other measurements or options, or is another "
                       "program's; the fit starts anew."));
}

TEST(Checkpoint, EveryFlippedBitAndEveryMissingByteIsNoticed) {
  const Case c = bright_block({8, 8, 4, 0.5});
  const Bytes good = all_checkpoints(c).front();
  const std::uint64_t origin = origin_of(c);
  ASSERT_NO_THROW(unseal(good, origin));
  std::mt19937 engine(1);
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes bad = good;
    bad[i] ^= std::byte{static_cast<unsigned char>(1U << engine() % 8U)};
    EXPECT_THROW(unseal(bad, origin), InputError) << "byte " << i << " of " << good.size();
  }
  for (std::size_t size = 0; size < good.size(); size += 1 + engine() % 7U) {
    EXPECT_THROW(unseal(std::span(good).first(size), origin), InputError) << size;
  }
  Bytes longer = good;
  longer.push_back(std::byte{0});
  EXPECT_THROW(unseal(longer, origin), InputError);
}

TEST(Checkpoint, WhereTheNewestIsDamagedTheOneBeforeIsGoneOnFrom) {
  const Case c = bright_block({8, 8, 4, 0.5});
  const ChannelFit whole = fit(c);
  const std::vector<Bytes> saved = all_checkpoints(c);
  ASSERT_GT(saved.size(), 4U);
  std::vector<Bytes> kept{saved[2], saved[3]};
  kept.back()[kept.back().size() / 2] ^= std::byte{4};
  Checkpoint checkpoint;
  checkpoint.load = [&]() -> std::optional<Bytes> {
    if (kept.empty()) return std::nullopt;
    const Bytes newest = std::move(kept.back());
    kept.pop_back();
    return newest;
  };
  const ChannelFit resumed = fit(c, checkpoint);
  EXPECT_TRUE(resumed.report.resumed);
  EXPECT_THAT(resumed.report.warnings,
              Contains("A checkpoint is damaged: its checksum does not match; the fit goes on from "
                       "the one before."));
  EXPECT_EQ(whole.medium.kappa.values(), resumed.medium.kappa.values());
  EXPECT_EQ(whole.medium.mu.values(), resumed.medium.mu.values());
}

/// `change` made to a state, sealed anew as if nothing were wrong.
template <class Change>
Bytes forged(const Case& c, const Bytes& sealed, const Change& change) {
  FitState state = FitState::from(unseal(sealed, origin_of(c)));
  change(state);
  return seal(state.bytes(), origin_of(c));
}

TEST(Checkpoint, ForgedStatesAreRefusedByWhatTheyHold) {
  const Case c = bright_block({8, 8, 4, 0.5});
  const std::vector<Bytes> saved = all_checkpoints(c);
  const Bytes& within = saved.front();
  const auto refused = [&](const Bytes& sealed, const char* what, const auto& change) {
    const FitReport report = fit(c, from(forged(c, sealed, change))).report;
    EXPECT_FALSE(report.resumed) << what;
    EXPECT_THAT(report.warnings, Contains(HasSubstr("A checkpoint is damaged"))) << what;
  };
  const double nan = std::nan("");
  refused(within, "level", [](FitState& s) { s.level = 1000000; });
  refused(within, "negative level", [](FitState& s) { s.level = -1; });
  refused(within, "closer where there is none", [](FitState& s) { s.closer = true; });
  refused(within, "correction's misfit", [&](FitState& s) { s.stage.corrected_chi2 = nan; });
  refused(within, "finished without its volume", [](FitState& s) {
    s.finished = true;
    s.fields = {};
  });
  refused(within, "steps", [](FitState& s) { s.stage.steps = -5; });
  refused(within, "weight", [](FitState& s) { s.weight = -1.0; });
  refused(within, "weight that is none", [&](FitState& s) { s.weight = nan; });
  refused(within, "fields", [](FitState& s) { s.fields.log_mu.pop_back(); });
  refused(within, "where the weight was begun",
          [](FitState& s) { s.stage.begun.log_kappa.pop_back(); });
  refused(within, "values of fields", [](FitState& s) { s.fields.log_mu[0] = 1e300; });
  refused(within, "correction", [](FitState& s) { s.correction.ratio.resize(1); });
  refused(within, "z", [](FitState& s) { s.stage.optimiser.z.resize(3); });
  refused(within, "gradient", [](FitState& s) { s.stage.optimiser.gradient.clear(); });
  refused(within, "pairs", [](FitState& s) {
    s.stage.optimiser.steps.assign(1, {1.0F});
    s.stage.optimiser.changes.assign(1, {1.0F});
    s.stage.optimiser.products.assign(1, {1.0, {1.0}, {1.0}});
  });
  refused(within, "products of pairs", [](FitState& s) {
    s.stage.optimiser.products.assign(1, {1.0, {}, {}});
  });
  refused(within, "blocks", [](FitState& s) { s.stage.blocks.pop_back(); });
  refused(within, "blocks' size", [](FitState& s) { s.stage.blocks.front().resize(1, 1); });
  refused(within, "no metric", [](FitState& s) { s.stage.scaled_blocks.front() *= -1e9; });
  refused(within, "small decreases", [](FitState& s) { s.stage.small_decreases = 3; });
  refused(within, "layers", [](FitState& s) { s.simpler.push_back({{0, 99}, {0, 0}, {0, 0}}); });
  refused(within, "history", [](FitState& s) { s.report.history.front().level = -7; });
  refused(within, "start", [&](FitState& s) { s.report.homogeneous_mu = nan; });
  refused(saved.back(), "end", [](FitState& s) { s.fields.log_kappa.clear(); });
  refused(saved.back(), "end on another grid", [](FitState& s) { s.level = 1; });
}

TEST(Checkpoint, ForgedEndsOfThePathOnACoarseGridAreRefused) {
  const Case c = bright_block({8, 8, 8, 0.5});
  const Bytes coarse = all_checkpoints(c).front();
  ASSERT_EQ(FitState::from(unseal(coarse, origin_of(c))).level, 1);
  for (bool FitState::*claim : {&FitState::last, &FitState::finished}) {
    const FitReport report =
        fit(c, from(forged(c, coarse, [&](FitState& s) { s.*claim = true; }))).report;
    EXPECT_FALSE(report.resumed);
    EXPECT_THAT(report.warnings, Contains(HasSubstr("A checkpoint is damaged")));
  }
}

TEST(Checkpoint, AnySizeThatIsDeclaredAllocatesNoMoreThanThereIs) {
  const Case c = bright_block({8, 8, 4, 0.5});
  const Bytes sealed = all_checkpoints(c).front();
  const std::span<const std::byte> state = unseal(sealed, origin_of(c));
  const Bytes good(state.begin(), state.end());
  for (const std::uint64_t forged : {~0ULL, 1ULL << 62, 1ULL << 32, 1ULL << 31, 1ULL << 20}) {
    for (std::size_t i = 0; i + sizeof(forged) <= good.size(); ++i) {
      Bytes bad = good;
      std::memcpy(bad.data() + i, &forged, sizeof(forged));
      try {
        FitState::from(bad);  // some of these bytes are numbers that may be anything
      } catch (const InputError&) {
      }
    }
  }
}

TEST(Checkpoint, WhateverIsWrittenIntoItTheFitEndsInOrder) {
  const Case c = bright_block({8, 8, 4, 0.5});
  const std::vector<Bytes> saved = all_checkpoints(c);
  const std::uint64_t origin = origin_of(c);
  std::mt19937_64 engine(7);
  int taken = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Bytes& sealed = saved[engine() % saved.size()];
    const std::span<const std::byte> state = unseal(sealed, origin);
    Bytes bad(state.begin(), state.end());
    // Mostly near the front, where sizes and choices lie.
    const std::size_t reach = trial % 2 == 0 ? std::size_t{80} : bad.size();
    const std::uint64_t junk = engine() >> (engine() % 64);
    std::memcpy(bad.data() + engine() % (reach - 8), &junk, 1 + engine() % 8);
    try {
      taken += fit(c, from(seal(bad, origin))).report.resumed ? 1 : 0;
    } catch (const InputError&) {
      // A volume that no solver takes is the fit's own to refuse.
    }
  }
  EXPECT_GT(taken, 0) << "forgeries must get past the checks for this to be a test";
}

}  // namespace
}  // namespace kappamu::inverse
