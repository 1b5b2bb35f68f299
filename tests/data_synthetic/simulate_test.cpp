// A whole simulated capture: what it leaves, what it keeps apart, that it repeats, and that scoring
// it against itself finds nothing wrong. How well the pipeline does on it is tested in tests/app.
#include "data_synthetic/simulate.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "data_synthetic/score.h"
#include "data_synthetic/truth.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "tests/data_synthetic/tiny_options.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::synthetic {
namespace {

namespace fs = std::filesystem;

using io::read_text;

SimulationOptions small_options() {
  SimulationOptions options = tiny_options();
  options.rays_per_side = 2;
  return options;
}

/// One tiny capture, shared by the tests.
class Simulated : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    Progress silent;
    report_ = simulate(small_options(), folder() / "a", "reference", silent);
  }
  static const OwnFolder& folder() {
    static const OwnFolder own;
    return own;
  }

  static SimulationReport report_;
};

SimulationReport Simulated::report_;

TEST_F(Simulated, SessionIsOneThatThePipelineReads) {
  const capture::Session session = capture::read_session(report_.session);
  EXPECT_EQ(session.patterns.size(), 4U + 6U);
  EXPECT_EQ(std::count_if(session.patterns.begin(), session.patterns.end(),
                          [](const capture::Pattern& pattern) {
                            return pattern.role == capture::PatternRole::fit;
                          }),
            4);
  EXPECT_GE(session.calibration.camera_boards.size(), 12U);
  EXPECT_GE(session.calibration.projector_planes.size(), 8U);
  EXPECT_EQ(session.calibration.sample_views.size(), 2U);
  EXPECT_FALSE(session.calibration.dark.empty());
  EXPECT_TRUE(session.calibration.white_target.has_value());
  EXPECT_FALSE(session.calibration.white_target->black_frames.empty());
  EXPECT_TRUE(session.calibration.colour_chart.has_value());
  const Image<std::uint16_t> frame =
      io::read_code_image(session.folder / session.patterns[0].frames[0].file);
  EXPECT_EQ(frame.width(), session.camera.width);
  EXPECT_LE(*std::max_element(frame.values().begin(), frame.values().end()), 4095);
}

TEST_F(Simulated, SessionHoldsNoTruth) {
  for (const auto& entry : fs::recursive_directory_iterator(report_.session)) {
    if (!entry.is_regular_file()) continue;
    const std::string extension = entry.path().extension();
    EXPECT_TRUE(extension == ".png" || entry.path().filename() == "session.json") << entry.path();
  }
  // Values that only the truth knows do not appear in the session's own file.
  const std::string text = read_text(report_.session / "session.json");
  const Truth truth = read_truth(report_.truth);
  for (const char* word : {"truth", "kappa_", "distortion", "seed", "pose", "intensity"}) {
    EXPECT_EQ(text.find(word), std::string::npos) << word;
  }
  for (const double value : {truth.camera_lens.fx, truth.camera_lens.cx, truth.projector.intensity,
                             truth.responsivity[0], truth.world_from_sample.translation.x()}) {
    EXPECT_EQ(text.find(nlohmann::json(value).dump()), std::string::npos) << value;
  }
}

TEST_F(Simulated, TransportGridIsNotTheFittedOne) {
  const Truth truth = read_truth(report_.truth);
  EXPECT_EQ(truth.transport_grid, truth.grid.refined(2));
  EXPECT_EQ(report_.transport_grid, truth.transport_grid);
  // The session says so in words, for the report to print.
  const GridShape& cells = truth.transport_grid;
  EXPECT_NE(capture::read_session(report_.session)
                .description.find(std::to_string(cells.nx) + " × " + std::to_string(cells.ny) +
                                  " × " + std::to_string(cells.nz) + " cells"),
            std::string::npos);
}

TEST_F(Simulated, RepeatsBitByBit) {
  Progress silent;
  const SimulationReport again = simulate(small_options(), folder() / "b", "reference", silent);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(report_.session)) {
    if (!entry.is_regular_file()) continue;
    const fs::path other = again.session / fs::relative(entry.path(), report_.session);
    EXPECT_EQ(read_text(entry.path()), read_text(other)) << entry.path();
    ++files;
  }
  EXPECT_GE(files, report_.frames);
  EXPECT_EQ(read_text(report_.truth / "truth.json"), read_text(again.truth / "truth.json"));
}

TEST_F(Simulated, RefusesToWriteOverASession) {
  Progress silent;
  EXPECT_THROW(simulate(small_options(), folder() / "a", "reference", silent), InputError);
}

TEST_F(Simulated, TruthSurvivesItsFile) {
  const Truth truth = read_truth(report_.truth);
  write_truth(folder() / "copy", truth);
  EXPECT_EQ(read_text(folder() / "copy" / "truth.json"), read_text(report_.truth / "truth.json"));
}

TEST_F(Simulated, PatternsLightTheSeenFaceMeasurably) {
  // Every seen voxel gets, under its brightest fit pattern, more than 100 electrons per pixel and
  // channel in the longest exposure.
  const Truth truth = read_truth(report_.truth);
  const capture::Session session = capture::read_session(report_.session);
  Image<float> brightest;
  for (const capture::Pattern& pattern : session.patterns) {
    const Image<float> picture =
        io::read_float_image(report_.truth / "radiance" / (pattern.id + ".exr"));
    if (brightest.empty()) brightest = picture;
    for (std::size_t i = 0; i < picture.size(); ++i) {
      brightest.values()[i] = std::max(brightest.values()[i], picture.values()[i]);
    }
  }
  std::size_t on_sample = 0;
  std::size_t measurable = 0;
  for (const float value : brightest.values()) {
    if (value <= 0.0F) continue;
    ++on_sample;
    measurable += value * 8.0 * truth.sensor.electrons_full_scale > 100.0 ? 1 : 0;
  }
  EXPECT_GT(on_sample, brightest.size() / 5);
  EXPECT_EQ(measurable, on_sample);
}

/// Of a fit that resolves every voxel.
void write_report(const fs::path& file, int layers) {
  nlohmann::json report;
  for (const char* channel : {"R", "G", "B"}) {
    nlohmann::json stated = nlohmann::json::array();
    for (int l = 0; l < layers; ++l) {
      stated.push_back({{"kappa_fwhm_mm", 0.0}, {"mu_fwhm_mm", 0.0}});
    }
    report["channels"].push_back({{"name", channel}, {"uncertainty", {{"layers", stated}}}});
  }
  std::ofstream(file) << report;
}

/// A run folder that holds the truth itself, averaged to the fitted grid, with known flaws.
fs::path perfect_run(const fs::path& folder, const SimulationReport& report, double mu_factor,
                     double radiance_factor) {
  const Truth truth = read_truth(report.truth);
  const GridShape& grid = truth.grid;
  for (const std::string& channel : truth.channels) {
    for (const std::string name : {"kappa", "mu"}) {
      const io::NpyArray fine = io::read_npy(report.truth / (name + "_" + channel + ".npy"));
      std::vector<float> mean(grid.cells());
      for (int z = 0; z < 2 * grid.nz; ++z) {
        for (int y = 0; y < 2 * grid.ny; ++y) {
          for (int x = 0; x < 2 * grid.nx; ++x) {
            mean[grid.index(x / 2, y / 2, z / 2)] +=
                static_cast<float>(fine.values[truth.transport_grid.index(x, y, z)] / 8.0 *
                                   (name == "mu" ? mu_factor : 1.0));
          }
        }
      }
      const std::vector<std::size_t> shape{static_cast<std::size_t>(grid.nz),
                                           static_cast<std::size_t>(grid.ny),
                                           static_cast<std::size_t>(grid.nx)};
      io::write_npy(folder / "fit" / (name + "_" + channel + ".npy"), shape, mean);
      for (float& value : mean) value *= 0.1F;  // the deviation it claims
      io::write_npy(folder / "fit" / ("std_" + name + "_" + channel + ".npy"), shape, mean);
    }
  }
  write_report(folder / "fit" / "fit.json", grid.nz);
  for (const auto& entry : fs::directory_iterator(report.truth / "radiance")) {
    io::ExrImage image = io::read_exr(entry.path());
    for (const char* channel : {"R", "G", "B"}) {
      std::vector<float>& values = image.channels[channel];
      for (float& value : values) value *= static_cast<float>(radiance_factor);
      image.channels[std::string("flags.") + channel] = std::vector<float>(values.size());
    }
    io::write_exr(folder / "hdr" / entry.path().filename(), image);
  }
  return folder;
}

TEST_F(Simulated, ScoreFindsTheErrorsThatWerePutIn) {
  Progress silent;
  const Score perfect = score_run(perfect_run(folder() / "perfect", report_, 1.0, 1.0),
                                  report_.truth, "reference", silent);
  const Score flawed = score_run(perfect_run(folder() / "flawed", report_, 1.5, 1.02),
                                 report_.truth, "reference", silent);
  // The truth averaged to fitted voxels is not the truth: its features are a voxel or two wide.
  // 1.5e-4 under 8 x 8 patches in the worst channel.
  constexpr double averaging_E = 1e-3;
  constexpr double float_rounding = 1e-5;
  ASSERT_TRUE(perfect.truth_E && flawed.truth_E);
  EXPECT_LT(*perfect.truth_E, averaging_E);
  EXPECT_GT(*perfect.truth_E, 0.0);
  EXPECT_GT(*flawed.truth_E, 2.0 * *perfect.truth_E);
  EXPECT_NEAR(*perfect.hdr_relative_error_median, 0.0, float_rounding);
  EXPECT_NEAR(*flawed.hdr_relative_error_median, 0.02, float_rounding);
  EXPECT_NEAR(*perfect.kappa_relative_error, 0.0, float_rounding);
  EXPECT_NEAR(*flawed.mu_relative_error, 0.5, float_rounding);
  EXPECT_EQ(flawed.mu_relative_error_by_depth.at("G").size(), 6U);
  EXPECT_EQ(flawed.kappa_coverage.at("G").within_two, 1.0);
  EXPECT_EQ(flawed.mu_coverage.at("G").within_two, 0.0);
  EXPECT_NEAR(flawed.mu_coverage.at("G").median, std::log(1.5) / 0.1, 1e-3);
  EXPECT_FALSE(perfect.calibration.has_value());
}

TEST_F(Simulated, ScoreOfAnEmptyFolderSaysWhatIsMissing) {
  Progress silent;
  fs::create_directories(folder() / "empty");
  const std::string sentence =
      sentence_of([&] { score_run(folder() / "empty", report_.truth, "reference", silent); });
  EXPECT_THAT(sentence, testing::HasSubstr("neither calibration/ nor hdr/ nor fit/"));
  EXPECT_THROW(score_run(report_.session, folder() / "empty", "reference", silent), InputError);
}

TEST(SimulationOptions, NameOptionValueAndBound) {
  const auto sentence = [](const std::function<void(SimulationOptions&)>& change) {
    SimulationOptions options;
    change(options);
    return sentence_of([&] { validate(options); }, "");
  };
  EXPECT_EQ(sentence([](SimulationOptions&) {}), "");
  EXPECT_EQ(sentence([](SimulationOptions& o) {
              o.light = capture::FitLight{capture::LightShape::patches, 0};
            }),
            "patches is 0: choose a value from 1 to 16");
  EXPECT_EQ(sentence([](SimulationOptions& o) { o.bit_depth = 7; }),
            "bit depth is 7: choose a value from 8 to 16");
  EXPECT_EQ(sentence([](SimulationOptions& o) { o.noise_scale = -0.5; }),
            "noise is -0.5: choose a value from 0 to 10");
  EXPECT_EQ(sentence([](SimulationOptions& o) {
              o.grid = {{40, 32, 2}};
            }),
            "grid is 2: choose a value from 4 to 1024");
  EXPECT_EQ(sentence([](SimulationOptions& o) {
              o.exposures_s = {0.1, 0.1};
            }),
            "exposures must be positive and rising: 0.1 s follows 0.1 s");
  EXPECT_EQ(sentence([](SimulationOptions& o) { o.exposures_s.clear(); }),
            "exposures are empty: give at least one time");
}

}  // namespace
}  // namespace kappamu::synthetic
