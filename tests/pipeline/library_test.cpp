// The pipeline as a library: another program runs it, sees its progress, stops it and goes on.
#include <gtest/gtest.h>

#include "core/error.h"
#include "io/measurements_file.h"
#include "io/read_file.h"
#include "pipeline/pipeline.h"
#include "tests/app/process.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::pipeline {
namespace {

/// Stops the work at the given call.
class StoppingProgress : public Progress {
 public:
  explicit StoppingProgress(int at) : left_(at) {}
  void update(const std::string&, double, const std::string&) override {
    if (--left_ == 0) throw Cancelled();
  }

 private:
  int left_;
};

class LibraryTest : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    const test_cases::Block block{.grid = {8, 8, 4, 0.5}};
    const auto truth = test_cases::make_truth(block.grid.refined(2), {.seed = 3});
    SurfaceMeasurements measurements = test_cases::measure(block, truth, 2);
    measurements.channels = {"R"};
    io::write_measurements(folder() / "measurements", measurements);
    options_.fit.solver.backend.device = "reference";
  }
  void fit(const std::string& run, Progress& progress) {
    Pipeline(folder() / "measurements", folder() / run).fit(options_, progress);
  }
  FitStageOptions options_;
};

TEST_F(LibraryTest, StoppedAndStartedAgainItEndsInTheSameVolume) {
  Progress quiet;
  fit("whole", quiet);
  StoppingProgress stopping(6);
  EXPECT_THROW(fit("stopped", stopping), Cancelled);
  EXPECT_FALSE(std::filesystem::exists(folder() / "stopped" / "fit" / "kappa_R.npy"));
  fit("stopped", quiet);
  for (const char* name : {"kappa_R.npy", "mu_R.npy"}) {
    EXPECT_EQ(io::read_bytes(folder() / "whole" / "fit" / name),
              io::read_bytes(folder() / "stopped" / "fit" / name))
        << name;
  }
}

}  // namespace
}  // namespace kappamu::pipeline
