#include "pipeline/stages/merge_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/session/session.h"
#include "io/measurements_file.h"
#include "io/read_file.h"
#include "tests/app/process.h"
#include "tests/app/tiny_session.h"

namespace kappamu::pipeline {
namespace {

namespace fs = std::filesystem;

class MergeStage : public TemporaryFolderTest {};

/// Takes every picture away as soon as it is merged.
class TakingAway : public Progress {
 public:
  explicit TakingAway(fs::path folder) : folder_(std::move(folder)) {}
  void update(const std::string& stage, double /*fraction*/, const std::string& detail) override {
    if (stage == "merge") taken += fs::remove(folder_ / (detail + ".exr")) ? 1 : 0;
  }
  std::size_t taken = 0;

 private:
  fs::path folder_;
};

TEST_F(MergeStage, MeasuresWhatItMergedWithoutReadingItBack) {
  const fs::path run = folder() / "run", calibration = tiny_run() / "calibration";
  const capture::Session session = capture::read_session(tiny_session());
  TakingAway progress(folder() / "out" / "hdr");
  run_merge_stage(session, {}, calibration, folder() / "out", progress);
  EXPECT_EQ(progress.taken, session.patterns.size());

  // A second attempt reads pictures that the first one left, and measures the same.
  Progress silent;
  run_merge_stage(session, {}, calibration, run, silent);
  fs::remove_all(run / "measurements");
  run_merge_stage(session, {}, calibration, run, silent);
  const SurfaceMeasurements once = io::read_measurements(folder() / "out" / "measurements");
  const SurfaceMeasurements again = io::read_measurements(run / "measurements");
  EXPECT_EQ(once.value, again.value);
  EXPECT_EQ(once.variance, again.variance);
  EXPECT_EQ(once.mask, again.mask);
}

TEST_F(MergeStage, StatesTheInstrumentThatTheSessionKnows) {
  capture::Session session = capture::read_session(tiny_session());
  session.smooth_error = SmoothError{1.5e-3, 4e-3};
  Progress silent;
  const auto shared = run_merge_stage(session, {}, tiny_run() / "calibration", folder(), silent);
  ASSERT_TRUE(shared.has_value());
  EXPECT_EQ(shared->source, "stated by the session");
  for (const char* measurements : {"measurements", "measurements_validate"}) {
    EXPECT_EQ(io::read_measurements(folder() / measurements).smooth_error, *session.smooth_error);
    EXPECT_THAT(io::read_text(folder() / measurements / "measurements.json"),
                testing::HasSubstr("stated by the session"));
  }
}

}  // namespace
}  // namespace kappamu::pipeline
