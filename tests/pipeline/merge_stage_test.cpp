#include "pipeline/stages/merge_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "capture/session/session.h"
#include "io/image/image_file.h"
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
  KnownFingerprints written;
  run_merge_stage(session, {}, calibration, run, silent, {}, &written);
  EXPECT_EQ(written.size(), session.patterns.size());
  for (const auto& [file, fingerprint] : written)
    EXPECT_EQ(fingerprint, content_fingerprint(run / file)) << file;
  fs::remove_all(run / "measurements");
  run_merge_stage(session, {}, calibration, run, silent, {}, &written);
  EXPECT_TRUE(written.empty());
  const SurfaceMeasurements once = io::read_measurements(folder() / "out" / "measurements");
  const SurfaceMeasurements again = io::read_measurements(run / "measurements");
  EXPECT_EQ(once.value, again.value);
  EXPECT_EQ(once.variance, again.variance);
  EXPECT_EQ(once.mask, again.mask);
}

/// A session of 2400 x 1600 pixels in colour, linear, of four patterns in three exposures.
fs::path large_session(const fs::path& folder) {
  constexpr int width = 2400, height = 1600, largest = 4095, black = 60;
  nlohmann::json json = nlohmann::json::parse(io::read_text(tiny_session() / "session.json"));
  json["camera"]["width"] = width;
  json["camera"]["height"] = height;
  json["camera"]["encoding"] = "linear";
  std::mt19937 random(1);
  const auto write = [&](const std::string& name, double exposure_s) {
    Image<std::uint16_t> codes(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) {
          const double light = 0.6 + 0.3 * std::sin(x / 30.0) * std::sin(y / 30.0);
          codes(x, y, c) = static_cast<std::uint16_t>(std::min<double>(
              largest, black + exposure_s * light * 3000.0 + static_cast<double>(random() % 16)));
        }
      }
    }
    io::write_code_image(folder / name, codes, 12);
    return nlohmann::json{{"file", name}, {"exposure_s", exposure_s}};
  };
  fs::create_directories(folder);
  json["calibration"]["dark"] = {write("dark.png", 0.0)};
  json["calibration"]["dark"][0]["exposure_s"] = 1.0;
  nlohmann::json& patterns = json["patterns"];
  patterns.erase(patterns.begin() + 4, patterns.end());
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    patterns[k]["frames"].clear();
    for (const double exposure_s : {0.06, 0.25, 1.0}) {
      const std::string name = std::to_string(k) + "_" + std::to_string(exposure_s) + ".png";
      patterns[k]["frames"].push_back(write(name, exposure_s));
    }
  }
  std::ofstream(folder / "session.json") << json;
  return folder;
}

TEST_F(MergeStage, HoldsTwoStacksAndAPicture) {
  const fs::path session = large_session(folder() / "session");
  const ProcessResult result =
      kappamu("merge " + session.string() + " -o " + (folder() / "run").string());
  EXPECT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_TRUE(fs::exists(folder() / "run" / "hdr"));
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const double megabytes = 1024e-6 * static_cast<double>(usage.ru_maxrss);
  std::printf("%.0f MB\n", megabytes);
  // Codes of three frames and radiance, variance and flags of 11.5 million values take 173 MB.
  EXPECT_LT(megabytes, 700.0);
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
